#include "simgap/core/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "simgap/core/text.h"

namespace simgap {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kQuietStart{1000};
constexpr milliseconds kTerminalInterval{100};
constexpr milliseconds kLogInterval{5000};
constexpr milliseconds kMovingInterval{1000};

/// What stderr shows; several threads draw on it.
struct Screen {
  std::mutex mutex;
  Progress* shown = nullptr;  ///< the newest that is at work
};
Screen& screen() {
  static Screen instance;
  return instance;
}

std::size_t terminalWidth() {
  struct winsize size = {};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kTextWidth;
}

/// That nobody reads stderr any more (`2>&1 | head`) is no error of the run: fmt::print would throw it.
void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

double secondsBetween(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

std::string formatDuration(double seconds) {
  if (!(seconds < 1e9)) return "unknown time";
  const long total = seconds > 0.0 ? std::lround(seconds) : 0;
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total % 3600 / 60);
}

void printSentence(std::string_view sentence) {
  const std::lock_guard lock(screen().mutex);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  Progress* const shown = screen().shown;
  const bool covered = shown != nullptr && shown->line_open_;
  if (covered) std::fputs("\r\x1b[K", stderr);
  say((terminal ? wrapped(sentence, terminalWidth()) : std::string(sentence)) + "\n");
  if (covered) shown->draw(Progress::Clock::now());
  std::fflush(stderr);
}

Progress::Progress(std::string label, std::size_t total, bool quiet, Unit unit)
    : label_(std::move(label)), total_(total), unit_(unit), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {
  const std::lock_guard lock(screen().mutex);
  below_ = std::exchange(screen().shown, this);
  if (terminal_ && !quiet_) mover_ = std::jthread([this](const std::stop_token& stop) { keepMoving(stop); });
}

Progress::~Progress() {
  mover_.request_stop();
  if (mover_.joinable()) mover_.join();
  const std::lock_guard lock(screen().mutex);
  Progress** place = &screen().shown;
  while (*place != nullptr && *place != this) place = &(*place)->below_;
  if (*place == this) *place = below_;
  if (line_open_) std::fputs(total_ > 0 ? "\n" : "\r\x1b[K", stderr);
  std::fflush(stderr);
}

std::string Progress::line(Clock::time_point now) const {
  std::string text = label_;
  if (total_ > 0)
    text += unit_ == Unit::kPercent ? fmt::format(" {} %", 100 * done_ / total_) : fmt::format(" {}/{}", done_, total_);
  const double elapsed = secondsBetween(start_, now);
  const bool estimated = done_ > first_ && done_ < total_;
  const double left = estimated ? secondsBetween(start_, last_news_) * static_cast<double>(total_ - done_) /
                                          static_cast<double>(done_ - first_) -
                                      secondsBetween(last_news_, now)
                                : 0.0;
  if (left > 0.0) {
    text += fmt::format(", {} left", formatDuration(left));
  } else if (total_ == 0 || done_ < total_) {
    text += fmt::format(", {} so far", formatDuration(elapsed));
  }
  if (!detail_.empty()) text += ", " + detail_;
  return printable(text);  // it names joints, and a file may call them anything
}

void Progress::draw(Clock::time_point now) {
  last_print_ = now;
  if (terminal_) {
    // One column stays free, because some terminals wrap when the last one is written. ESC [K clears a longer old line.
    say(fmt::format("\r{}\x1b[K", firstCharacters(line(now), terminalWidth() - 1)));
    line_open_ = true;
  } else {
    say(line(now) + "\n");
  }
  std::fflush(stderr);
}

void Progress::keepMoving(std::stop_token stop) {
  std::unique_lock lock(screen().mutex);
  while (!stop.stop_requested()) {
    ended_.wait_for(lock, stop, kMovingInterval, [] { return false; });
    const Clock::time_point now = Clock::now();
    if (!stop.stop_requested() && screen().shown == this && now - last_print_ >= kMovingInterval) draw(now);
  }
}

void Progress::update(std::size_t done, std::string_view detail) {
  if (quiet_) return;
  const std::lock_guard lock(screen().mutex);
  const Clock::time_point now = Clock::now();
  done_ = done;
  detail_ = detail;
  last_news_ = now;
  const bool due = now - start_ >= kQuietStart && now - last_print_ >= (terminal_ ? kTerminalInterval : kLogInterval);
  // A line that stays on the screen must not end short of the last unit of work.
  const bool completes = line_open_ && done >= total_;
  if (due || completes) draw(now);
}

}  // namespace simgap
