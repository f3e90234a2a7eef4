/// \file
/// The tables of a capture, written as the frames come: memory does not grow with their number.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "simgap/capture/joint_angles.h"
#include "simgap/capture/marker_targets.h"

namespace simgap {

/// Text that waits in an unnamed file of the system until it is known that the run succeeded.
class TextSpool {
 public:
  TextSpool();
  void add(std::string_view text);
  /// The bytes from `begin` on, as many as `into` holds. \throws ConfigError: there are fewer
  void read(std::size_t begin, std::span<char> into) const;
  /// Writes `head` and all text to a file, completely or not at all. \throws ConfigError
  void writeTo(const std::filesystem::path& file, std::string_view head = {}) const;

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/// frames.csv: per frame and target what was seen of it. `visible` markers were seen by both
/// cameras (bits in `mask`), `single` further ones by one; the pose maps the
/// body's frame into the left camera's; cov_* is the upper triangle over rotation vector (camera axes) and position.
std::string framesCsvHeader();
std::string framesCsvRows(const TargetSet& targets, const FramePair& frame, std::size_t number, double time);

/// joints.csv: the joint columns of a pose set, their standard deviations, and for revolute joints the rotation off
/// their axis.
std::string jointsCsvHeader(const std::vector<CaptureJoint>& joints);
std::string jointsCsvRow(const std::vector<CaptureJoint>& joints, const JointSample& sample);

/// TRC (marker trajectories, mm, camera frame), as OpenSim and motion capture programs read it. A marker that was not
/// seen has empty cells.
std::string trcHeader(const TargetSet& targets, double rate, std::size_t frames, const std::string& name);
std::string trcRow(const TargetSet& targets, const FramePair& frame, std::size_t number, double time);

/// Both images side by side with blobs, markers and their names, and the targets' axes drawn in (BGR).
cv::Mat drawOverlay(const StereoCameras& cameras, const TargetSet& targets, const FramePair& frame, const cv::Mat& left,
                    const cv::Mat& right);

}  // namespace simgap
