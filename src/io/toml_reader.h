#pragma once

#include <toml++/toml.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "units/angle.h"
#include "units/length.h"

namespace trunnion {

/// One table of a TOML file, read key by key: what was asked for is known, what is left over is an error. For sources
/// of io only: the header pulls in toml++.
class TomlReader {
 public:
  /// Throws InputError for text that is no TOML, with file and line.
  static toml::table parse(std::string_view text, const std::string& name);

  TomlReader(const toml::table& table, std::string file, std::string path)
      : table_(table), file_(std::move(file)), path_(std::move(path)) {}

  std::optional<std::string> text(const std::string& key);
  std::optional<double> number(const std::string& key);
  std::optional<bool> truth(const std::string& key);
  /// A list of exactly `count` numbers.
  std::optional<std::vector<double>> numbers(const std::string& key, std::size_t count);
  /// [low, high] with low < high.
  std::optional<std::pair<double, double>> range(const std::string& key);
  /// A list of texts; empty if there is none.
  std::vector<std::string> texts(const std::string& key);
  std::optional<TomlReader> table(const std::string& key);
  /// The tables [[key]], in the order of the file.
  std::vector<TomlReader> tables(const std::string& key);
  /// The names of all keys, for tables whose keys are free; they count as known.
  std::vector<std::string> keys();
  const toml::node* node(const std::string& key);

  double positive(const std::string& key, double otherwise);
  std::string required_text(const std::string& key);
  /// Checks `format` and `version`.
  void check_format(const std::string& format);
  /// Throws InputError for a key that nobody asked for, naming the nearest known one.
  void finish() const;

  /// "file:line: path.key: …"
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  std::string full(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  const toml::table& table_;
  std::string file_, path_;
  std::vector<std::string> known_;
};

}  // namespace trunnion
