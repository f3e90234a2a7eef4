#include "simgap/capture/joint_calibration.h"

#include <Eigen/Dense>
#include <cmath>

#include <fmt/format.h>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestFrames = 10;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Standard deviations of the rotation about its mean, along its principal axes, smallest first. [rad]
Eigen::Vector3d rotationSpread(const std::vector<TargetPose>& poses) {
  const Eigen::Matrix3d mean = meanRotation(poses).toRotationMatrix();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const TargetPose& pose : poses) {
    const Eigen::Vector3d w = logSo3(Eigen::Quaterniond(Eigen::Matrix3d(pose.rotation * mean.transpose())));
    covariance += w * w.transpose() / static_cast<double>(poses.size());
  }
  return symmetricEigen(covariance).values.cwiseMax(0.0).cwiseSqrt();
}

/// R c_child + t = c_parent for all frames: the normal equations over (c_child, c_parent).
struct CentreEquations {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();

  explicit CentreEquations(const std::vector<TargetPose>& poses) {
    for (const TargetPose& pose : poses) {
      Eigen::Matrix<double, 3, 6> row;
      row << pose.rotation, -Eigen::Matrix3d::Identity();
      matrix += row.transpose() * row;
      right -= row.transpose() * pose.origin;
    }
  }
};

double residualOf(const std::vector<TargetPose>& poses, const Vector6& centre) {
  double squares = 0.0;
  for (const TargetPose& pose : poses) squares += (pose * centre.head<3>() - centre.tail<3>()).squaredNorm();
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

void expectRange(const FunctionalJoint& joint, const JointCalibrationOptions& options) {
  const JointKind& kind = kindOf(joint.type);
  if (kind.counted * joint.range < options.min_range) {
    throw DataError(fmt::format("joint {}: the motion spans only {:.1f} {} {}, expected at least {:.1f} {}", joint.name,
                                kind.shown(joint.range), kind.error_unit,
                                kindOf(joint.type).slides ? "along its axis"
                                : kind.has_axis           ? "about its axis"
                                                          : "about its second axis",
                                kind.shown(options.min_range / kind.counted), kind.error_unit));
  }
  if (!(joint.centre_sd <= options.max_centre_sd)) {
    throw DataError(
        fmt::format("joint {}: its centre is known only within {:.1f} mm, expected {:.1f} mm: move further "
                    "and about more axes",
                    joint.name, 1e3 * joint.centre_sd, 1e3 * options.max_centre_sd));
  }
}

/// The child moves along one direction of the parent's target and does not turn.
void calibrateSlide(const CaptureJoint& joint, const std::vector<TargetPose>& poses,
                    const JointCalibrationOptions& options, FunctionalJoint& result) {
  const auto n = static_cast<double>(poses.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const TargetPose& pose : poses) mean += pose.origin / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const TargetPose& pose : poses) covariance += (pose.origin - mean) * (pose.origin - mean).transpose() / n;
  const SymmetricEigen ways = symmetricEigen(covariance);
  const Eigen::Vector3d spread = ways.values.cwiseMax(0.0).cwiseSqrt();  // smallest first
  result.range = 4.0 * spread[2];
  result.residual = std::hypot(spread[0], spread[1]);
  result.centre_sd = result.residual / std::sqrt(n);
  result.axis_sd = result.residual / std::max(spread[2] * std::sqrt(n), 1e-12);
  result.condition = ways.values[2] / std::max(ways.values.sum(), 1e-30);
  result.axis_in_parent = ways.vectors.col(2);
  result.axis_in_child = meanRotation(poses).conjugate() * result.axis_in_parent;
  // Where it is at 0: as the rig has it, until frames of a zero pose say so.
  if (result.axis_in_parent.dot(joint.axis) < 0.0) {
    result.axis_in_parent *= -1.0;
    result.axis_in_child *= -1.0;
  }
  result.in_parent = mean + (joint.zero - mean.dot(result.axis_in_parent)) * result.axis_in_parent;
  const double turned = 4.0 * rotationSpread(poses)[2];
  if (turned > options.min_range) {
    throw DataError(
        fmt::format("joint {}: its target turns by {:.1f} deg in the other's, expected a slide, which turns "
                    "nothing",
                    joint.name, toDegrees(turned)));
  }
  expectRange(result, options);
}

}  // namespace

std::vector<TargetPose> relativePoses(const CaptureJoint& joint, const std::vector<MotionFrame>& motion) {
  std::vector<TargetPose> poses;
  for (const MotionFrame& frame : motion) {
    const auto& parent = frame.targets[joint.parent];
    const auto& child = frame.targets[joint.child];
    if (!parent || !child) continue;
    const Eigen::Matrix3d inverse = parent->rotation.transpose();
    poses.push_back({inverse * child->rotation, inverse * (child->origin - parent->origin)});
  }
  return poses;
}

Eigen::Quaterniond meanRotation(const std::vector<TargetPose>& poses) {
  std::vector<Eigen::Quaterniond> rotations;
  rotations.reserve(poses.size());
  for (const TargetPose& pose : poses) rotations.emplace_back(pose.rotation);
  return meanRotation(rotations);
}

std::vector<MotionFrame> readMotion(const CsvTable& table, const TargetSet& targets) {
  const std::vector<double> frame = table.quantity("frame", "");
  const std::vector<std::string> name = table.text("target");
  std::array<std::vector<double>, 4> q;
  for (std::size_t i = 0; i < 4; ++i) q[i] = table.quantity(std::array{"qw", "qx", "qy", "qz"}[i], "");
  const std::vector<double> x = table.quantity("x", "m"), y = table.quantity("y", "m"), z = table.quantity("z", "m");
  std::vector<MotionFrame> motion;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const int target = targets.indexOf(name[row]);
    if (target < 0) table.fail(row, fmt::format("the target file has no target '{}'", name[row]));
    if (!(std::abs(frame[row]) < 1e15))
      table.fail(row, fmt::format("found frame {:g}, expected its number", frame[row]));
    const auto number = static_cast<long>(frame[row]);
    if (motion.empty() || motion.back().frame != number) {
      motion.push_back({number, std::vector<std::optional<TargetPose>>(targets.targets.size())});
    }
    const Eigen::Quaterniond rotation(q[0][row], q[1][row], q[2][row], q[3][row]);
    if (std::abs(rotation.norm() - 1.0) > 1e-3) table.fail(row, "the quaternion is not of unit length");
    motion.back().targets[target] = TargetPose{rotation.normalized().toRotationMatrix(), {x[row], y[row], z[row]}};
  }
  return motion;
}

FunctionalJoint calibrateJoint(const CaptureJoint& joint, const std::vector<MotionFrame>& motion,
                               const JointCalibrationOptions& options) {
  const std::vector<TargetPose> poses = relativePoses(joint, motion);
  FunctionalJoint result;
  result.name = joint.name;
  result.type = joint.type;
  result.frames = poses.size();
  if (poses.size() < kFewestFrames) {
    throw DataError(fmt::format("joint {}: both targets were seen in {} frames, expected at least {}", joint.name,
                                poses.size(), kFewestFrames));
  }
  if (kindOf(joint.type).slides) {
    calibrateSlide(joint, poses, options, result);
    return result;
  }
  const bool revolute = kindOf(joint.type).has_axis;
  const Eigen::Vector3d spread = rotationSpread(poses);
  const double about_second = 4.0 * spread[1];
  result.range = revolute ? 4.0 * spread[2] : about_second;
  if (revolute && about_second > options.min_range) {
    throw DataError(
        fmt::format("joint {}: its target turns by {:.1f} deg about a second axis, expected a revolute joint, which "
                    "turns about one",
                    joint.name, toDegrees(about_second)));
  }

  const CentreEquations equations(poses);
  const auto n = static_cast<double>(poses.size());
  const SymmetricEigen normal = symmetricEigen(equations.matrix);
  // Along its axis a revolute joint has no centre: that direction is left out of the solution, and is the axis.
  const Eigen::Index first = revolute ? 1 : 0;
  Vector6 centre = Vector6::Zero();
  Matrix6 inverse = Matrix6::Zero();
  for (Eigen::Index k = first; k < 6; ++k) {
    const Vector6 v = normal.vectors.col(k);
    const double eigenvalue = std::max(normal.values[k], 1e-12 * n);
    centre += v * v.dot(equations.right) / eigenvalue;
    inverse += v * v.transpose() / eigenvalue;
  }
  result.condition = std::sqrt(std::max(0.0, normal.values[first]) / n);
  result.in_child = centre.head<3>();
  result.in_parent = centre.tail<3>();
  result.residual = residualOf(poses, centre);
  const double variance = result.residual * result.residual * n / (3.0 * n - 6.0);
  result.centre_sd =
      std::sqrt(variance * std::max(symmetricEigen(inverse.topLeftCorner<3, 3>()).values.maxCoeff(),
                                    symmetricEigen(inverse.bottomRightCorner<3, 3>()).values.maxCoeff()));
  if (revolute) {
    const Vector6 v = normal.vectors.col(0);
    result.axis_in_child = v.head<3>().normalized();
    result.axis_in_parent = v.tail<3>().normalized();
    // The smallest singular value is what noise leaves of the axis; the next one is what the motion gives.
    result.axis_sd = std::sqrt(std::max(0.0, normal.values[0]) / (n * n)) / std::max(result.condition, 1e-9);
  }
  expectRange(result, options);
  return result;
}

}  // namespace simgap
