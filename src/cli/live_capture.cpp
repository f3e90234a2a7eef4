#include "live_capture.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "simgap/core/interrupt.h"
#include "simgap/core/progress.h"

namespace simgap {
namespace {

/// Says once in a while how fast and how late the angles come.
class LiveDisplay {
 public:
  explicit LiveDisplay(bool quiet) : quiet_(quiet), progress_("capture: live", 0, quiet) {}

  void show(const LiveFigures& live, double seconds, double latency) {
    const bool terminal = isatty(STDERR_FILENO) == 1;
    worst_ = std::max(worst_, latency);
    if (quiet_ || seconds < last_ + (terminal ? 0.5 : 5.0)) return;
    const double span = seconds - last_;
    const auto per_second = [span](std::size_t now, std::size_t then) {
      return static_cast<double>(now - then) / span;
    };
    const std::string text =
        fmt::format("{:.1f} pairs/s, {:.1f} poses/s, {:.1f} ms behind the image at most, {} dropped",
                    per_second(live.pairs, pairs_), per_second(live.poses, poses_), 1e3 * worst_,
                    live.counts.dropped[0] + live.counts.dropped[1]);
    if (terminal) {
      progress_.update(0, text);
    } else {
      printSentence("capture: " + text);
    }
    last_ = seconds;
    pairs_ = live.pairs;
    poses_ = live.poses;
    worst_ = 0.0;
  }

 private:
  bool quiet_;
  Progress progress_;
  double last_ = 0.0, worst_ = 0.0;
  std::size_t pairs_ = 0, poses_ = 0;
};

}  // namespace

LiveFigures followCameras(CaptureRun& run, LiveCameras& cameras, const std::optional<double>& duration, bool quiet) {
  const auto since = [&](LiveClock::time_point moment) {
    return std::chrono::duration<double>(moment - cameras.start()).count();
  };
  LiveFigures live;
  live.started_unix = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count() -
                      since(LiveClock::now());
  LiveDisplay display(quiet);
  while (!interruptRequested() && !(duration && since(LiveClock::now()) >= *duration)) {
    const LiveCameras::Wait found = cameras.next();
    if (found == LiveCameras::Wait::kEnd) break;
    if (found == LiveCameras::Wait::kNothing) continue;
    live.poses += run.add(cameras.left(), cameras.right(), live.pairs, since(cameras.taken()));
    ++live.pairs;
    const double latency = since(LiveClock::now()) - since(cameras.taken());
    live.latency.add(latency);
    live.counts = cameras.counts();
    display.show(live, since(LiveClock::now()), latency);
  }
  interruptAnswered();
  live.counts = cameras.counts();
  live.seconds = since(LiveClock::now());
  return live;
}

}  // namespace simgap
