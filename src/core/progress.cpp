#include "simgap/core/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

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

std::size_t terminalWidth() {
  struct winsize size = {};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

/// The first `characters` of a UTF-8 text, not cut inside a character.
std::string_view firstCharacters(std::string_view text, std::size_t characters) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins_character = (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
    if (begins_character && seen++ == characters) return text.substr(0, i);
  }
  return text;
}

}  // namespace

std::string formatDuration(double seconds) {
  if (!(seconds < 1e9)) return "unknown time";
  const long total = seconds > 0.0 ? std::lround(seconds) : 0;
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total % 3600 / 60);
}

Progress::Progress(std::string label, std::size_t total, bool quiet)
    : label_(std::move(label)), total_(total), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (line_open_) std::fputs("\n", stderr);
}

void Progress::update(std::size_t done, std::string_view detail) {
  if (quiet_) return;
  const Clock::time_point now = Clock::now();
  const bool due = now - start_ >= kQuietStart && now - last_print_ >= (terminal_ ? kTerminalInterval : kLogInterval);
  // A line that stays on the screen must not end short of the last unit of work.
  const bool completes = line_open_ && done >= total_;
  if (!due && !completes) return;
  last_print_ = now;

  std::string line = fmt::format("{} {}/{}", label_, done, total_);
  if (done > first_ && done < total_) {
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double left = elapsed * static_cast<double>(total_ - done) / static_cast<double>(done - first_);
    line += fmt::format(", {} left", formatDuration(left));
  }
  if (!detail.empty()) line += fmt::format(", {}", detail);
  line = printable(line);  // it names joints, and a file may call them anything

  if (terminal_) {
    // One column stays free, because some terminals wrap when the last one is written. ESC [K clears a longer old line.
    fmt::print(stderr, "\r{}\x1b[K", firstCharacters(line, terminalWidth() - 1));
    line_open_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

}  // namespace simgap
