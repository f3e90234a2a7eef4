#include "simgap/capture/capture_files.h"

#include <fmt/format.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/run_directory.h"

namespace simgap {
namespace {

constexpr std::array<const char*, 6> kPoseNames = {"rx", "ry", "rz", "x", "y", "z"};

// Okabe & Ito (2008), BGR.
const std::array<cv::Scalar, 6> kColours = {cv::Scalar(233, 180, 86),  cv::Scalar(0, 159, 230),
                                            cv::Scalar(115, 158, 0),   cv::Scalar(66, 228, 240),
                                            cv::Scalar(167, 121, 204), cv::Scalar(178, 114, 0)};

cv::Point toPoint(const Eigen::Vector2d& pixel) { return {cvRound(pixel.x()), cvRound(pixel.y())}; }

/// One camera's picture of a frame.
class OverlayPainter {
 public:
  OverlayPainter(cv::Mat canvas, const CameraIntrinsics& camera, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& translation)
      : canvas_(std::move(canvas)), camera_(camera), rotation_(rotation), translation_(translation) {}

  void blob(const Blob& blob) const {
    const int radius = cvRound(std::sqrt(blob.area / 3.14)) + 4;
    cv::circle(canvas_, toPoint(blob.centre), radius, cv::Scalar(128, 128, 128), 1, cv::LINE_AA);
  }

  void target(const MarkerTarget& target, const TargetFrame& frame, const cv::Scalar& colour) const {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < target.markers.size(); ++i) {
      const Eigen::Vector3d marker = frame.pose * target.markers[i];
      middle += marker / static_cast<double>(target.markers.size());
      const cv::Point at = pixel(marker);
      // A full ring: seen and used; a cross: where the pose puts a marker that was not seen.
      if (frame.candidate[i] >= 0) {
        cv::circle(canvas_, at, 8, colour, 1, cv::LINE_AA);
      } else {
        cv::drawMarker(canvas_, at, colour, cv::MARKER_TILTED_CROSS, 8, 1, cv::LINE_AA);
      }
      write(std::to_string(i), at + cv::Point(9, -5), colour);
    }
    const std::array<cv::Scalar, 3> axes = {cv::Scalar(80, 80, 255), cv::Scalar(80, 255, 80), cv::Scalar(255, 120, 80)};
    for (int k = 0; k < 3; ++k) {
      cv::line(canvas_, pixel(middle), pixel(middle + 0.04 * frame.pose.rotation.col(k)), axes[k], 1, cv::LINE_AA);
    }
    write(fmt::format("{} {:.3f} mm", target.name, 1e3 * frame.rms), pixel(middle) + cv::Point(30, 30), colour);
  }

 private:
  cv::Point pixel(const Eigen::Vector3d& in_left) const {
    return toPoint(projectPixel(camera_, rotation_ * in_left + translation_));
  }
  void write(const std::string& text, const cv::Point& at, const cv::Scalar& colour) const {
    cv::putText(canvas_, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv::LINE_AA);
  }

  cv::Mat canvas_;
  const CameraIntrinsics& camera_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
};

}  // namespace

TextSpool::TextSpool() : file_(std::tmpfile(), std::fclose) {
  if (!file_) throw ConfigError("no temporary file can be made");
}

void TextSpool::add(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) {
    throw ConfigError("a temporary file cannot be written: is the disk full?");
  }
}

void TextSpool::read(std::size_t begin, std::span<char> into) const {
  const bool found = std::fflush(file_.get()) == 0 && ::fseeko(file_.get(), static_cast<off_t>(begin), SEEK_SET) == 0;
  if (!found || std::fread(into.data(), 1, into.size(), file_.get()) != into.size()) {
    throw ConfigError("a temporary file cannot be read");
  }
}

void TextSpool::writeTo(const std::filesystem::path& file, std::string_view head) const {
  std::fflush(file_.get());
  std::rewind(file_.get());
  std::array<char, 1 << 16> buffer;
  writeFileAtomically(file, [&]() -> std::string_view {
    if (!head.empty()) return std::exchange(head, {});
    return {buffer.data(), std::fread(buffer.data(), 1, buffer.size(), file_.get())};
  });
}

std::string framesCsvHeader() {
  std::string text = "frame,time_s,target,visible,single,n,mask,rms_mm,epipolar_px,qw,qx,qy,qz,x_m,y_m,z_m";
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i; j < 6; ++j) text += fmt::format(",cov_{}_{}", kPoseNames[i], kPoseNames[j]);
  }
  return text + "\n";
}

std::string framesCsvRows(const TargetSet& targets, const FramePair& frame, std::size_t number, double time) {
  std::string text;
  for (std::size_t t = 0; t < frame.targets.size(); ++t) {
    const TargetFrame& target = frame.targets[t];
    if (!target.found) continue;  // a table of numbers has no empty cells
    unsigned mask = 0;
    for (std::size_t i = 0; i < target.candidate.size(); ++i) mask |= target.candidate[i] >= 0 ? 1U << i : 0U;
    const Eigen::Quaterniond q(target.pose.rotation);
    const double sign = q.w() < 0.0 ? -1.0 : 1.0;
    const Eigen::Vector3d& o = target.pose.origin;
    text += fmt::format("{},{:.6f},{},{},{},{},{},{:.5f},{:.4f},{:.9f},{:.9f},{:.9f},{:.9f},{:.8f},{:.8f},{:.8f}",
                        number, time, targets.targets[t].name, target.visible, target.single, target.candidate.size(),
                        mask, 1e3 * target.rms, target.epipolar, sign * q.w(), sign * q.x(), sign * q.y(), sign * q.z(),
                        o.x(), o.y(), o.z());
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) text += fmt::format(",{:.4e}", target.covariance(i, j));
    }
    text += "\n";
  }
  return text;
}

std::string jointsCsvHeader(const std::vector<CaptureJoint>& joints) {
  std::string text = "frame,time_s";
  for (const CaptureJoint& joint : joints) {
    for (const std::string& column : positionColumns(joint.type, joint.name)) text += "," + column;
  }
  for (const CaptureJoint& joint : joints) {
    text += fmt::format(",{}_sd_{}", joint.name, kindOf(joint.type).unit);
    if (kindOf(joint.type).has_axis) text += fmt::format(",{}_off_axis_rad", joint.name);
  }
  return text + "\n";
}

std::string jointsCsvRow(const std::vector<CaptureJoint>& joints, const JointSample& sample) {
  std::string text = fmt::format("{},{:.6f}", sample.frame, sample.time);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (const double cell : kindOf(joints[j].type).cells(sample.joints[j])) text += fmt::format(",{:.9f}", cell);
  }
  for (std::size_t j = 0; j < joints.size(); ++j) {
    text += fmt::format(",{:.4e}", sample.sd[j]);
    if (kindOf(joints[j].type).has_axis) text += fmt::format(",{:.4e}", sample.off_axis[j]);
  }
  return text + "\n";
}

std::string trcHeader(const TargetSet& targets, double rate, std::size_t frames, const std::string& name) {
  std::string markers, axes;
  std::size_t count = 0;
  for (const MarkerTarget& target : targets.targets) {
    for (std::size_t i = 0; i < target.markers.size(); ++i) {
      ++count;
      markers += fmt::format("\t{}_{}\t\t", target.name, i);
      axes += fmt::format("\tX{0}\tY{0}\tZ{0}", count);
    }
  }
  return fmt::format(
      "PathFileType\t4\t(X/Y/Z)\t{}\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
      "{:.6g}\t{:.6g}\t{}\t{}\tmm\t{:.6g}\t1\t{}\n"
      "Frame#\tTime{}\n\t{}\n\n",
      name, rate, rate, frames, count, rate, frames, markers, axes);
}

std::string trcRow(const TargetSet& targets, const FramePair& frame, std::size_t number, double time) {
  std::string text = fmt::format("{}\t{:.6f}", number + 1, time);
  for (std::size_t t = 0; t < targets.targets.size(); ++t) {
    for (std::size_t i = 0; i < targets.targets[t].markers.size(); ++i) {
      const int candidate = frame.targets[t].candidate[i];
      if (candidate < 0) {
        text += "\t\t\t";
      } else {
        const Eigen::Vector3d p = 1e3 * frame.points[candidate].point;
        text += fmt::format("\t{:.4f}\t{:.4f}\t{:.4f}", p.x(), p.y(), p.z());
      }
    }
  }
  return text + "\n";
}

cv::Mat drawOverlay(const StereoCameras& cameras, const TargetSet& targets, const FramePair& frame, const cv::Mat& left,
                    const cv::Mat& right) {
  cv::Mat both, canvas;
  cv::hconcat(left, right, both);
  cv::cvtColor(both, canvas, cv::COLOR_GRAY2BGR);
  const OverlayPainter on_left(canvas.colRange(0, left.cols), cameras.left, Eigen::Matrix3d::Identity(),
                               Eigen::Vector3d::Zero());
  const OverlayPainter on_right(canvas.colRange(left.cols, canvas.cols), cameras.right, cameras.rotation,
                                cameras.translation);
  for (const Blob& blob : frame.left) on_left.blob(blob);
  for (const Blob& blob : frame.right) on_right.blob(blob);
  for (std::size_t t = 0; t < frame.targets.size(); ++t) {
    if (!frame.targets[t].found) continue;
    for (const OverlayPainter* painter : {&on_left, &on_right}) {
      painter->target(targets.targets[t], frame.targets[t], kColours[t % kColours.size()]);
    }
  }
  return canvas;
}

}  // namespace simgap
