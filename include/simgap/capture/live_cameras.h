/// \file
/// Two cameras that run while their images are looked at: what comes too late is dropped and counted, never waited for.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace simgap {

using LiveClock = std::chrono::steady_clock;

/// What became of the frames of both cameras, left and right.
struct LiveCounts {
  std::array<std::size_t, 2> frames{};    ///< that came
  std::array<std::size_t, 2> dropped{};   ///< that made room for newer ones
  std::array<std::size_t, 2> unpaired{};  ///< without one of the other camera within half a period
};

/// Each camera fills a short queue of its own, from which the oldest frames drop out. A pair are two frames that came
/// within half a period of one another.
class LiveCameras {
 public:
  /// \param left, right  number of a V4L2 device ("0"), its path, or a video, which is played at the rate it was taken.
  /// \param rate  frames a second to ask the devices for, and to play videos at; without it as they say.
  /// \throws ConfigError: no such device or file, a rate that nobody says. DataError: it gives no images.
  LiveCameras(const std::string& left, const std::string& right, std::optional<double> rate);
  ~LiveCameras();
  LiveCameras(const LiveCameras&) = delete;
  LiveCameras& operator=(const LiveCameras&) = delete;

  enum class Wait { kPair, kNothing, kEnd };
  /// Waits for the next pair, at most 50 ms. \returns kEnd when a camera has ended and no pair is left.
  Wait next();

  const cv::Mat& left() const;
  const cv::Mat& right() const;
  LiveClock::time_point taken() const;  ///< when the later image of the pair came (of a video: was due)
  LiveClock::time_point start() const;  ///< before the first image
  double rate() const;                  ///< [Hz] of the left camera
  LiveCounts counts() const;

 private:
  class Camera;
  std::unique_ptr<Camera> cameras_[2];
  struct Frame {
    cv::Mat image;
    LiveClock::time_point taken;
  };
  std::array<std::optional<Frame>, 2> pair_;
  std::array<std::size_t, 2> unpaired_{};
  LiveClock::time_point start_;
};

}  // namespace simgap
