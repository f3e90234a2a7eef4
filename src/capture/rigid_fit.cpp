#include "simgap/capture/rigid_fit.h"

#include <Eigen/Dense>
#include <cmath>

#include "simgap/core/rotation.h"

namespace simgap {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kRounds = 10;          // Gauss-Newton from Umeyama's pose needs two or three
constexpr double kSmallStep = 1e-9;  // [rad], [m]

/// Normal equations of the reprojection residuals at a pose.
struct Normal {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  double square_sum = 0.0;

  /// \param towards  d point / d (w, origin) in this camera's frame. \returns the squares of the two residuals.
  double add(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 6>& towards, const Eigen::Vector2d& seen,
             double focal) {
    const Eigen::Vector2d residual = focal * (p.head<2>() / p.z() - seen);
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0 / p.z(), 0.0, -p.x() / (p.z() * p.z()), 0.0, 1.0 / p.z(), -p.y() / (p.z() * p.z());
    const Eigen::Matrix<double, 2, 6> jacobian = focal * projection * towards;
    matrix += jacobian.transpose() * jacobian;
    gradient += jacobian.transpose() * residual;
    square_sum += residual.squaredNorm();
    return residual.squaredNorm();
  }
};

Normal normalEquations(const StereoCameras& cameras, const TargetPose& pose, std::span<const Eigen::Vector3d> body,
                       std::span<const PointCandidate* const> seen, std::vector<double>* marker_px) {
  Normal normal;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Eigen::Vector3d arm = pose.rotation * body[i];
    Eigen::Matrix<double, 3, 6> towards;
    towards << -cross(arm), Eigen::Matrix3d::Identity();
    const Eigen::Vector3d in_left = arm + pose.origin;
    double squares = normal.add(in_left, towards, seen[i]->left_image, cameras.left.focal() / seen[i]->left_spread);
    squares += normal.add(cameras.rotation * in_left + cameras.translation, cameras.rotation * towards,
                          seen[i]->right_image, cameras.right.focal() / seen[i]->right_spread);
    if (marker_px != nullptr) marker_px->push_back(std::sqrt(squares / 4.0));
  }
  return normal;
}

}  // namespace

TargetPose umeyama(std::span<const Eigen::Vector3d> body, std::span<const Eigen::Vector3d> camera) {
  Eigen::Vector3d body_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d camera_mean = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(body.size());
  for (std::size_t i = 0; i < body.size(); ++i) {
    body_mean += body[i] / n;
    camera_mean += camera[i] / n;
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < body.size(); ++i) {
    covariance += (camera[i] - camera_mean) * (body[i] - body_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // The sign keeps the determinant at +1: a mirrored target then misses its points instead of matching them.
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  TargetPose pose;
  pose.rotation = svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  pose.origin = camera_mean - pose.rotation * body_mean;
  return pose;
}

double fitRms(const TargetPose& pose, std::span<const Eigen::Vector3d> body, std::span<const Eigen::Vector3d> camera) {
  double squares = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) squares += (pose * body[i] - camera[i]).squaredNorm();
  return std::sqrt(squares / static_cast<double>(body.size()));
}

RefinedPose refinePose(const StereoCameras& cameras, const TargetPose& start, std::span<const Eigen::Vector3d> body,
                       std::span<const PointCandidate* const> seen) {
  RefinedPose refined;
  refined.pose = start;
  for (int round = 0; round < kRounds; ++round) {
    const Normal normal = normalEquations(cameras, refined.pose, body, seen, nullptr);
    const Vector6 step = normal.matrix.ldlt().solve(-normal.gradient);
    refined.pose.rotation = expSo3(step.head<3>()).toRotationMatrix() * refined.pose.rotation;
    refined.pose.origin += step.tail<3>();
    if (step.norm() < kSmallStep) break;
  }
  const Normal normal = normalEquations(cameras, refined.pose, body, seen, &refined.marker_px);
  refined.square_sum = normal.square_sum;
  refined.cofactor = normal.matrix.ldlt().solve(Matrix6::Identity());
  return refined;
}

}  // namespace simgap
