/// \file
/// Progress with the time left, on stderr: one rewritten line on a terminal, a line every few seconds otherwise.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace simgap {

/// Seconds as people read them: "8 s", "3 min 20 s", "2 h 05 min".
std::string formatDuration(double seconds);

class Progress {
 public:
  /// \param label  what is counted: "generation".  \param total  how many there are.
  /// \param quiet  print nothing.
  Progress(std::string label, std::size_t total, bool quiet);
  ~Progress();  ///< ends the rewritten line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total`. Cheap: prints at most 10 times a second on a terminal, every 5 s otherwise, and nothing within
  /// the first second of work. `detail` ends the line. Call it from one thread.
  void update(std::size_t done, std::string_view detail = {});
  /// Work that was done before this process began, left out of the time estimate.
  void startFrom(std::size_t done) { first_ = done; }

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  std::size_t total_;
  std::size_t first_ = 0;
  bool quiet_;
  bool terminal_;
  bool line_open_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_print_ = start_;
};

}  // namespace simgap
