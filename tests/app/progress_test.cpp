#include "app/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "app/command.h"

namespace trunnion {

// The program's own talk belongs to its main.
void Talk::say(const std::string& line) const { std::fprintf(stderr, "%s\n", line.c_str()); }

namespace {

/// Standard error on a terminal, as long as this lives.
class TerminalErrors {
 public:
  TerminalErrors() : main_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)), stderr_(::dup(STDERR_FILENO)) {
    if (main_ < 0 || ::grantpt(main_) != 0 || ::unlockpt(main_) != 0) return;
    const int terminal = ::open(::ptsname(main_), O_RDWR | O_NOCTTY);
    ::dup2(terminal, STDERR_FILENO);
    ::close(terminal);
  }
  TerminalErrors(const TerminalErrors&) = delete;
  TerminalErrors& operator=(const TerminalErrors&) = delete;
  ~TerminalErrors() {
    ::dup2(stderr_, STDERR_FILENO);
    ::close(stderr_);
    ::close(main_);
  }

  /// What was written so far.
  std::string text() const {
    std::string all;
    char buffer[4096];
    for (ssize_t got = 0; (got = ::read(main_, buffer, sizeof buffer)) > 0;)
      all.append(buffer, static_cast<std::size_t>(got));
    return all;
  }

 private:
  int main_, stderr_;
};

TEST(Progress, IsToldBySeveralThreadsWhileItIsWritten) {
  constexpr int kWorkers = 4;
  constexpr std::chrono::milliseconds kWork{1700};  // the first line comes after a second, the next after half of one
  TerminalErrors terminal;
  const Talk talk;
  {
    Progress progress(talk, "draws", 4e9, "draws");
    const auto end = std::chrono::steady_clock::now() + kWork;
    std::vector<std::jthread> workers;
    for (int worker = 0; worker < kWorkers; ++worker)
      workers.emplace_back([&progress, end, worker] {
        for (double done = worker; std::chrono::steady_clock::now() < end; done += kWorkers) progress.at(done);
      });
  }
  EXPECT_THAT(terminal.text(), testing::ContainsRegex("\rdraws: [0-9]+ %, [0-9.e+]+ draws/s, .* left"));
}

TEST(Progress, TellsTheStepWhereNobodyKnowsHowMuchThereIs) {
  constexpr std::chrono::milliseconds kWork{1300};
  TerminalErrors terminal;
  const Talk talk;
  {
    Progress progress(talk, "search");
    const auto end = std::chrono::steady_clock::now() + kWork;
    const std::jthread worker([&progress, end] {
      for (int step = 0; std::chrono::steady_clock::now() < end; ++step) progress.now("step " + std::to_string(step));
    });
  }
  EXPECT_THAT(terminal.text(), testing::ContainsRegex("\rsearch: step [0-9]+, [0-9.]+ s"));
}

}  // namespace
}  // namespace trunnion
