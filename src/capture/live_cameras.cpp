#include "simgap/capture/live_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>

#include "image_module.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr std::size_t kQueue = 3;  // frames that wait for their partner; more would only be older
constexpr std::chrono::milliseconds kLongestWait{50};
constexpr double kFastest = 1000.0;  // [Hz]

/// "/dev/video0" for "0".
std::string devicePath(const std::string& name) {
  const bool number = !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
  return number ? "/dev/video" + name : name;
}

double usableRate(const std::string& name, double said, std::optional<double> wanted) {
  const double rate = wanted.value_or(said);
  if (rate > 0.0 && rate <= kFastest) return rate;
  throw ConfigError(fmt::format("{}: found a rate of {:g} Hz, expected one up to {:g} Hz: name it with --rate", name,
                                rate, kFastest));
}

}  // namespace

/// A thread that takes the frames of one camera as they come.
class LiveCameras::Camera {
 public:
  Camera(const std::string& name, std::optional<double> rate) : name_(devicePath(name)) {
    std::error_code why;
    const std::filesystem::file_status status = std::filesystem::status(name_, why);
    if (!std::filesystem::exists(status)) {
      throw ConfigError(
          fmt::format("{}: found no camera or video, expected LEFT,RIGHT as numbers of cameras (0), their "
                      "paths (/dev/video0) or videos",
                      name_));
    }
    played_ = std::filesystem::is_regular_file(status);
    video_.reset(played_ ? imageModule().open_video(name_.c_str())
                         : imageModule().open_camera(name_.c_str(), rate.value_or(0.0)));
    if (video_ == nullptr) throw DataError(fmt::format("{}: cannot be opened as a camera or a video", name_));
    rate_ = usableRate(name_, video_->rate(), rate);
  }

  void run(LiveClock::time_point start) {
    thread_ = std::jthread([this, start](const std::stop_token& stop) { take(start, stop); });
  }

  /// The oldest frame that waits; stays in the queue.
  std::optional<Frame> oldest(LiveClock::time_point until) {
    std::unique_lock lock(mutex_);
    arrived_.wait_until(lock, until, [this] { return !queue_.empty() || ended_; });
    return queue_.empty() ? std::nullopt : std::optional(queue_.front());
  }
  void pop(LiveClock::time_point taken) {
    const std::lock_guard lock(mutex_);
    if (!queue_.empty() && queue_.front().taken == taken) queue_.pop_front();  // else it has dropped out meanwhile
  }
  bool ended() {
    const std::lock_guard lock(mutex_);
    return ended_ && queue_.empty();
  }
  std::array<std::size_t, 2> counts() {
    const std::lock_guard lock(mutex_);
    return {frames_, dropped_};
  }
  double rate() const { return rate_; }

 private:
  void take(LiveClock::time_point start, const std::stop_token& stop) {
    const std::chrono::duration<double> period(1.0 / rate_);
    for (std::size_t frame = 0; !stop.stop_requested(); ++frame) {
      cv::Mat image;
      if (!video_->read(image)) break;
      LiveClock::time_point taken = LiveClock::now();
      if (played_) {
        taken = start + std::chrono::duration_cast<LiveClock::duration>(static_cast<double>(frame) * period);
        std::this_thread::sleep_until(taken);
      }
      const std::lock_guard lock(mutex_);
      queue_.push_back({std::move(image), taken});
      ++frames_;
      if (queue_.size() > kQueue) {
        queue_.pop_front();
        ++dropped_;
      }
      arrived_.notify_one();
    }
    const std::lock_guard lock(mutex_);
    ended_ = true;
    arrived_.notify_one();
  }

  std::string name_;
  bool played_ = false;
  double rate_ = 0.0;
  std::unique_ptr<VideoFrames> video_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Frame> queue_;
  std::size_t frames_ = 0, dropped_ = 0;
  bool ended_ = false;
  std::jthread thread_;  ///< last: it uses the others
};

LiveCameras::LiveCameras(const std::string& left, const std::string& right, std::optional<double> rate) {
  cameras_[0] = std::make_unique<Camera>(left, rate);
  cameras_[1] = std::make_unique<Camera>(right, rate);
  start_ = LiveClock::now();
  for (const auto& camera : cameras_) camera->run(start_);
}

LiveCameras::~LiveCameras() = default;

LiveCameras::Wait LiveCameras::next() {
  const auto until = LiveClock::now() + kLongestWait;
  const auto half =
      std::chrono::duration_cast<LiveClock::duration>(std::chrono::duration<double>(0.5 / cameras_[0]->rate()));
  while (true) {
    for (std::size_t side = 0; side < 2; ++side) pair_[side] = cameras_[side]->oldest(until);
    if (!pair_[0] || !pair_[1]) return cameras_[0]->ended() || cameras_[1]->ended() ? Wait::kEnd : Wait::kNothing;
    const auto lag = pair_[1]->taken - pair_[0]->taken;
    if (lag <= half && -lag <= half) break;
    const std::size_t older = lag > half ? 0 : 1;
    cameras_[older]->pop(pair_[older]->taken);
    ++unpaired_[older];
  }
  for (std::size_t side = 0; side < 2; ++side) cameras_[side]->pop(pair_[side]->taken);
  return Wait::kPair;
}

const cv::Mat& LiveCameras::left() const { return pair_[0]->image; }
const cv::Mat& LiveCameras::right() const { return pair_[1]->image; }
LiveClock::time_point LiveCameras::taken() const { return std::max(pair_[0]->taken, pair_[1]->taken); }
LiveClock::time_point LiveCameras::start() const { return start_; }
double LiveCameras::rate() const { return cameras_[0]->rate(); }

LiveCounts LiveCameras::counts() const {
  LiveCounts counts;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto [frames, dropped] = cameras_[side]->counts();
    counts.frames[side] = frames;
    counts.dropped[side] = dropped;
  }
  counts.unpaired = unpaired_;
  return counts;
}

}  // namespace simgap
