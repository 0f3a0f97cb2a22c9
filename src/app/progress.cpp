#include "app/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "units/number_text.h"

namespace trunnion {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSilence{1000}, kStep{500};
constexpr double kMinutesFrom_s = 100;

/// "13 s", "4 min".
std::string duration_text(double seconds) {
  if (seconds >= kMinutesFrom_s) return formatted("%.0f min", seconds / 60);
  return formatted(seconds < 9.95 ? "%.1f s" : "%.0f s", seconds);
}

}  // namespace

Progress::Progress(const Talk& talk, std::string what, double total, std::string unit)
    : talk_(talk), what_(std::move(what)), unit_(std::move(unit)), total_(total) {
  if (!talk_.quiet && isatty(STDERR_FILENO) == 1)
    teller_ = std::jthread([this](const std::stop_token& stop) { tick(stop); });
}

Progress::~Progress() {
  if (teller_.joinable()) {
    teller_.request_stop();
    teller_.join();
  }
  if (written_) std::fputs("\r\033[K", stderr);
  if (!talk_.verbose) return;
  const double took = seconds();
  talk_.say(what_ + ": " + (total_ > 0 ? formatted("%.6g ", done_) + unit_ + " in " : std::string()) +
            duration_text(took));
}

void Progress::at(double done) {
  const std::scoped_lock lock(guard_);
  done_ = std::max(done_, done);
}

void Progress::now(const std::string& step) {
  const std::scoped_lock lock(guard_);
  step_ = step;
}

double Progress::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::string Progress::line() const {
  const double took = seconds(), rate = done_ / took;
  std::string text = what_ + ": ";
  if (total_ <= 0 || done_ <= 0) return text + (step_.empty() ? "" : step_ + ", ") + duration_text(took);
  text += formatted("%.0f %%, ", 100 * std::min(1.0, done_ / total_)) + formatted("%.3g ", rate) + unit_ + "/s, ";
  return text + duration_text(std::max(0.0, total_ - done_) / rate) + " left";
}

void Progress::tick(const std::stop_token& stop) {
  std::unique_lock lock(guard_);
  const auto stopped = [&](milliseconds wait) {
    return wake_.wait_for(lock, stop, wait, [] { return false; }) || stop.stop_requested();
  };
  for (milliseconds wait = kSilence; !stopped(wait); wait = kStep) {
    std::fprintf(stderr, "\r%s\033[K", line().c_str());
    written_ = true;
  }
}

}  // namespace trunnion
