#include "simgap/capture/joint_calibration.h"

#include <Eigen/Dense>
#include <cmath>

#include <fmt/format.h>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestFrames = 10;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Child in parent, one per frame in which both were seen.
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

Eigen::Quaterniond meanOf(const std::vector<TargetPose>& poses) {
  std::vector<Eigen::Quaterniond> rotations;
  for (const TargetPose& pose : poses) rotations.emplace_back(pose.rotation);
  return meanRotation(rotations);
}

/// Standard deviations of the rotation about its mean, along its principal axes, smallest first. [rad]
Eigen::Vector3d rotationSpread(const std::vector<TargetPose>& poses) {
  const Eigen::Matrix3d mean = meanOf(poses).toRotationMatrix();
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
  if (joint.range < options.min_range) {
    throw DataError(fmt::format("joint {}: the motion spans only {:.1f} deg about {}, expected at least {:.1f} deg",
                                joint.name, toDegrees(joint.range),
                                joint.type == JointType::kRevolute ? "its axis" : "its second axis",
                                toDegrees(options.min_range)));
  }
  if (!(joint.centre_sd <= options.max_centre_sd)) {
    throw DataError(
        fmt::format("joint {}: its centre is known only within {:.1f} mm, expected {:.1f} mm: move further "
                    "and about more axes",
                    joint.name, 1e3 * joint.centre_sd, 1e3 * options.max_centre_sd));
  }
}

/// The rotation that takes the pair (a, b) of orthogonal unit vectors to (to_a, to_b).
Eigen::Matrix3d alignPairs(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& to_a,
                           const Eigen::Vector3d& to_b) {
  Eigen::Matrix3d from, to;
  from << a, b, a.cross(b);
  to << to_a, to_b, to_a.cross(to_b);
  return to * from.transpose();
}

void moveMarkers(MarkerTarget& target, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin) {
  for (Eigen::Vector3d& marker : target.markers) marker = rotation * (marker - origin);
}

}  // namespace

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
  const bool revolute = joint.type == JointType::kRevolute;
  const Eigen::Vector3d spread = rotationSpread(poses);
  result.range = 4.0 * (revolute ? spread[2] : spread[1]);

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

ArmJointCalibration calibrateArmJoints(const Rig& rig, const TargetSet& targets, const std::vector<MotionFrame>& motion,
                                       const JointCalibrationOptions& options) {
  const bool paper_arm = rig.joints.size() == 2 && rig.joints[0].type == JointType::kSpherical &&
                         rig.joints[1].type == JointType::kRevolute && rig.joints[1].parent == rig.joints[0].child;
  if (!paper_arm) {
    throw ConfigError(
        "calibrate-joints needs a rig with two joints: a spherical one, then a revolute one on its child");
  }
  ArmJointCalibration result;
  result.shoulder = calibrateJoint(rig.joints[0], motion, options);
  result.elbow = calibrateJoint(rig.joints[1], motion, options);
  const Eigen::Vector3d& named_axis = rig.joints[1].axis;
  // SARA knows the axis but not its sense: that of the rig's axis.
  if (result.elbow.axis_in_parent.dot(named_axis) < 0.0) {
    result.elbow.axis_in_parent *= -1.0;
    result.elbow.axis_in_child *= -1.0;
  }
  // The elbow is the point of its axis nearest to the shoulder.
  const Eigen::Vector3d& shoulder = result.shoulder.in_child;
  const double along = (shoulder - result.elbow.in_parent).dot(result.elbow.axis_in_parent);
  result.elbow.in_parent += along * result.elbow.axis_in_parent;
  result.elbow.in_child += along * result.elbow.axis_in_child;
  result.upper_arm = (shoulder - result.elbow.in_parent).norm();

  const Eigen::Vector3d up = (shoulder - result.elbow.in_parent).normalized();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d z_across = z - z.dot(named_axis) * named_axis;
  if (z_across.norm() < 1e-3)
    throw ConfigError("calibrate-joints needs an elbow axis across the humerus (not along z)");
  const Eigen::Matrix3d humerus = alignPairs(result.elbow.axis_in_parent, up, named_axis, z_across.normalized());
  Eigen::Matrix3d torso = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d forearm = Eigen::Matrix3d::Identity();
  if (options.zero_first >= 0) {
    std::vector<MotionFrame> still;
    for (const MotionFrame& frame : motion) {
      if (frame.frame >= options.zero_first && frame.frame <= options.zero_last) still.push_back(frame);
    }
    const auto shoulders = relativePoses(rig.joints[0], still);
    const auto elbows = relativePoses(rig.joints[1], still);
    if (shoulders.empty() || elbows.empty()) {
      throw DataError(fmt::format("no frame from {} to {} shows all targets: the zero pose is unknown",
                                  options.zero_first, options.zero_last));
    }
    // In the zero pose all bones point the same way.
    torso = humerus * meanOf(shoulders).toRotationMatrix().transpose();
    forearm = humerus * meanOf(elbows).toRotationMatrix();
    result.zero_pose = true;
  }
  // The forearm turns about exactly the axis that the rig names.
  const Eigen::Vector3d axis = forearm * result.elbow.axis_in_child;
  forearm = rotationBetween(axis.normalized(), named_axis).toRotationMatrix() * forearm;

  result.targets = targets;
  const auto target = [&](int index) -> MarkerTarget& { return result.targets.targets[index]; };
  moveMarkers(target(rig.joints[0].parent), torso, result.shoulder.in_parent);
  moveMarkers(target(rig.joints[0].child), humerus, result.shoulder.in_child);
  moveMarkers(target(rig.joints[1].child), forearm, result.elbow.in_child);
  return result;
}

}  // namespace simgap
