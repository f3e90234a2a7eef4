/// \file
/// Progress with the time left, on stderr: one rewritten line on a terminal, a line every few seconds otherwise.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

namespace simgap {

/// Seconds as people read them: "8 s", "3 min 20 s", "2 h 05 min".
std::string formatDuration(double seconds);

/// A sentence on stderr, on a line of its own, above the progress that a terminal shows; broken to the terminal's
/// width, and one line everywhere else.
void printSentence(std::string_view sentence);

/// On a terminal the line moves every second, whether or not there is news: the time left counts down, and where it is
/// not known, the time since the beginning counts up. Of several at once, the newest is shown.
class Progress {
 public:
  enum class Unit { kCount, kPercent };
  /// \param label  what is counted: "generation".  \param total  how many there are; 0: work that cannot be counted,
  /// shown by its time on a terminal only.  \param quiet  print nothing.  \param unit  how `done` of `total` is shown.
  Progress(std::string label, std::size_t total, bool quiet, Unit unit = Unit::kCount);
  ~Progress();  ///< ends the rewritten line; one that counts nothing is wiped out
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `total`. Cheap: prints at most 10 times a second on a terminal, every 5 s otherwise, and nothing within
  /// the first second of work. `detail` ends the line. Call it from one thread.
  void update(std::size_t done, std::string_view detail = {});
  /// Work that was done before this process began, left out of the time estimate.
  void startFrom(std::size_t done) { first_ = done_ = done; }

 private:
  friend void printSentence(std::string_view sentence);
  using Clock = std::chrono::steady_clock;
  std::string line(Clock::time_point now) const;
  void draw(Clock::time_point now);
  void keepMoving(std::stop_token stop);

  std::string label_;
  std::size_t total_;
  std::size_t first_ = 0, done_ = 0;
  std::string detail_;
  Unit unit_;
  bool quiet_;
  bool terminal_;
  bool line_open_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_news_ = start_, last_print_ = start_;
  Progress* below_ = nullptr;  ///< the one that was shown before
  std::condition_variable_any ended_;
  std::jthread mover_;  ///< last: it uses the others
};

}  // namespace simgap
