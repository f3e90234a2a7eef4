#include "simgap/capture/triangulation.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace simgap {
namespace {

constexpr double kCentreGate = 0.1;  // [px] four standard deviations of a free blob's centre, generously

}  // namespace

void correctToEpipolar(const Eigen::Matrix3d& essential, Eigen::Vector2d& left, Eigen::Vector2d& right) {
  // Lindstrom 2010, listing 3 (niter2), with x' E x = 0 written as right' E left = 0.
  const Eigen::Matrix2d upper = essential.topLeftCorner<2, 2>();
  Eigen::Vector2d n = (essential * left.homogeneous()).head<2>();
  Eigen::Vector2d n_left = (essential.transpose() * right.homogeneous()).head<2>();
  const double a = n.dot(upper * n_left);
  const double b = 0.5 * (n.squaredNorm() + n_left.squaredNorm());
  const double c = right.homogeneous().dot(essential * left.homogeneous());
  const double d = std::sqrt(std::max(0.0, b * b - a * c));
  double lambda = c / (b + d);
  const Eigen::Vector2d d_right = lambda * n;
  const Eigen::Vector2d d_left = lambda * n_left;
  n -= upper * d_left;
  n_left -= upper.transpose() * d_right;
  lambda *= 2.0 * d / (n.squaredNorm() + n_left.squaredNorm());
  right -= lambda * n;
  left -= lambda * n_left;
}

Triangulator::Triangulator(const StereoCameras& cameras, double marker_radius, double gate)
    : cameras_(cameras), essential_(cameras.essential()), radius_(marker_radius), gate_(gate) {}

void Triangulator::pair(int left, int right, const std::array<double, 2>& spread, double signed_error) {
  PointCandidate c;
  c.left = left;
  c.right = right;
  c.left_spread = spread[0];
  c.right_spread = spread[1];
  c.epipolar = signed_error;
  const cv::Point2d l = left_[left];
  const cv::Point2d r = right_[right];
  const auto triangulate = [&] {
    Eigen::Vector2d on_left = c.left_image;
    Eigen::Vector2d on_right = c.right_image;
    correctToEpipolar(essential_, on_left, on_right);
    // The rays now meet: R a x_left + T = b x_right, crossed with x_right.
    const Eigen::Vector3d turned = cameras_.rotation * on_left.homogeneous();
    const Eigen::Vector3d normal = turned.cross(on_right.homogeneous());
    const double depth = normal.dot(on_right.homogeneous().cross(cameras_.translation)) / normal.squaredNorm();
    c.point = depth * on_left.homogeneous();
  };
  c.left_image = {l.x, l.y};
  c.right_image = {r.x, r.y};
  triangulate();
  const double left_depth = c.point.z();
  const double right_depth = (cameras_.rotation * c.point + cameras_.translation).z();
  // Cheirality, with the sphere outside the cameras; also refuses parallel rays.
  if (!(left_depth > 2.0 * radius_ && right_depth > 2.0 * radius_ && left_depth < 1e3)) return;
  c.left_image *= 1.0 - std::pow(radius_ / left_depth, 2);
  c.right_image *= 1.0 - std::pow(radius_ / right_depth, 2);
  triangulate();
  candidates_.push_back(c);
}

const std::vector<PointCandidate>& Triangulator::candidates(const std::vector<Blob>& left,
                                                            const std::vector<Blob>& right) {
  const auto normalize = [&](const CameraIntrinsics& camera, const std::vector<Blob>& blobs,
                             std::vector<cv::Point2d>& normalized) {
    pixels_.clear();
    for (const Blob& blob : blobs) pixels_.emplace_back(blob.centre.x(), blob.centre.y());
    undistort(camera, pixels_, normalized);
  };
  normalize(cameras_.left, left, left_);
  normalize(cameras_.right, right, right_);
  candidates_.clear();
  const double focal = cameras_.right.focal();
  for (std::size_t i = 0; i < left_.size(); ++i) {
    const Eigen::Vector3d line = essential_ * Eigen::Vector3d(left_[i].x, left_[i].y, 1.0);
    const double scale = focal / line.head<2>().norm();
    for (std::size_t j = 0; j < right_.size(); ++j) {
      const double error = scale * line.dot(Eigen::Vector3d(right_[j].x, right_[j].y, 1.0));
      const double uncertain = kCentreGate * (left[i].spread + right[j].spread - 2.0);
      if (std::abs(error) >= gate_ + uncertain) continue;
      pair(static_cast<int>(i), static_cast<int>(j), {left[i].spread, right[j].spread}, error);
    }
  }
  return candidates_;
}

PointCandidate Triangulator::observe(int left, int right, const Eigen::Vector3d& expected,
                                     const std::vector<Blob>& left_blobs, const std::vector<Blob>& right_blobs) const {
  PointCandidate c;
  c.left = left;
  c.right = right;
  c.point = expected;
  c.left_spread = left < 0 ? std::numeric_limits<double>::infinity() : left_blobs[left].spread;
  c.right_spread = right < 0 ? std::numeric_limits<double>::infinity() : right_blobs[right].spread;
  const double right_depth = (cameras_.rotation * expected + cameras_.translation).z();
  const auto shrunk = [this](const cv::Point2d& seen, double depth) {
    return Eigen::Vector2d((1.0 - std::pow(radius_ / depth, 2)) * Eigen::Vector2d(seen.x, seen.y));
  };
  if (left >= 0) c.left_image = shrunk(left_[left], expected.z());
  if (right >= 0) c.right_image = shrunk(right_[right], right_depth);
  return c;
}

Eigen::Matrix3d Triangulator::covariancePerPixel(const PointCandidate& candidate) const {
  const Eigen::Vector3d& point = candidate.point;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  const auto add = [&](const Eigen::Matrix3d& rotation, const Eigen::Vector3d& p, double focal, double spread) {
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
    const Eigen::Matrix<double, 2, 3> jacobian = focal / spread * projection * rotation;
    information += jacobian.transpose() * jacobian;
  };
  add(Eigen::Matrix3d::Identity(), point, cameras_.left.focal(), candidate.left_spread);
  add(cameras_.rotation, cameras_.rotation * point + cameras_.translation, cameras_.right.focal(),
      candidate.right_spread);
  return information.inverse();
}

}  // namespace simgap
