#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace trunnion {

/// Whatever goes wrong in Trunnion. The text is one line for a person: where, what was found, what was wanted.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file that cannot be read, or that does not say what it must (exit status 2).
class InputError : public Error {
 public:
  explicit InputError(const std::string& text) : Error(text) {}
  /// "file: text", for what concerns the file as a whole or a key in it.
  InputError(const std::string& file, const std::string& text) : Error(file + ": " + text) {}
  /// "file:line: text", lines counted from 1.
  InputError(const std::string& file, std::size_t line, const std::string& text)
      : Error(file + ":" + std::to_string(line) + ": " + text) {}
};

/// A command line, or a combination of options, that makes no sense (exit status 2).
class UsageError : public Error {
 public:
  using Error::Error;
};

/// A machine or model that contradicts itself or another file (exit status 2).
class ModelError : public Error {
 public:
  using Error::Error;
};

/// A request beyond what was measured, or beyond a limit that protects a machine (exit status 1).
class RangeError : public Error {
 public:
  using Error::Error;
};

/// A check that protects a machine was not passed: a refused block, another serial number, an unconfirmed format (exit
/// status 1).
class RefusalError : public Error {
 public:
  using Error::Error;
};

}  // namespace trunnion
