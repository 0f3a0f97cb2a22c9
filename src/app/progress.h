#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "app/command.h"

namespace trunnion {

/// Tells on standard error how far a piece of work has come: on a terminal, from the first second on, one line that is
/// written over and wiped at the end,
///   draws of corrected: 34 %, 512 draws/s, 13 s left
/// or, where nobody knows how much there is to do, how long it has taken. With --verbose a line stays that says what
/// was done in which time, terminal or not; with --quiet there is nothing.
class Progress {
 public:
  /// `total` of `unit`; 0: unknown.
  Progress(const Talk& talk, std::string what, double total = 0, std::string unit = "");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  /// So much of the total is done; from any thread, and cheap.
  void at(double done);
  /// What is being done now, where the total is unknown.
  void now(const std::string& step);

 private:
  double seconds() const;
  std::string line() const;  ///< holds guard_
  void tick(const std::stop_token& stop);

  const Talk& talk_;
  std::string what_, unit_, step_;
  double total_, done_ = 0;
  bool written_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  mutable std::mutex guard_;
  std::condition_variable_any wake_;
  std::jthread teller_;  ///< last: it sees all of the above
};

}  // namespace trunnion
