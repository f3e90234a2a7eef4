// A ball: any rotation of the child's frame in the parent's.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "simgap/core/joint_kind.h"

namespace simgap::joint_kinds::spherical {
namespace {

constexpr std::string_view kColumns[] = {"_qw", "_qx", "_qy", "_qz"};
constexpr std::string_view kVelocityColumns[] = {"_velocity_x_rad_s", "_velocity_y_rad_s", "_velocity_z_rad_s"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  std::array<std::vector<double>, 4> q;
  for (std::size_t i = 0; i < 4; ++i) q[i] = table.quantity(joint + std::string(kColumns[i]), "");
  std::vector<JointPosition> positions(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Eigen::Quaterniond rotation(q[0][row], q[1][row], q[2][row], q[3][row]);
    if (std::abs(rotation.norm() - 1.0) > kUnitLengthTolerance) {
      table.fail(row, fmt::format("quaternion of joint {}: found length {:.6g}, expected 1 within {:g}", joint,
                                  rotation.norm(), kUnitLengthTolerance));
    }
    positions[row].rotation = rotation.normalized();
  }
  return positions;
}

std::vector<double> cells(const JointPosition& position) {
  const Eigen::Quaterniond& q = position.rotation;
  return {q.w(), q.x(), q.y(), q.z()};
}

double angle(const JointPosition& position) { return geodesicAngle(position.rotation, Eigen::Quaterniond::Identity()); }

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return logSo3(to.rotation * from.rotation.conjugate());
}

double error(const JointPosition& a, const JointPosition& b) { return geodesicAngle(a.rotation, b.rotation); }

JointPosition between(const JointPosition& from, const JointPosition& to, double part) {
  return {from.rotation.slerp(part, to.rotation), 0.0};
}

JointPosition moved(const JointPosition& position, const Eigen::Vector3d& step) {
  return {position.rotation * Eigen::Quaterniond(expSo3(step)), 0.0};
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& /*axis*/, const JointPosition& position) {
  return position.rotation.toRotationMatrix();
}

JointPosition mean(std::span<const JointPosition> repeats) {
  std::vector<Eigen::Quaterniond> rotations;
  for (const JointPosition& repeat : repeats) rotations.push_back(repeat.rotation);
  return {meanRotation(rotations), 0.0};
}

}  // namespace

extern const JointKind entry;
const JointKind entry{.type = JointType::kSpherical,
                      .name = "spherical",
                      .degrees_of_freedom = 3,
                      .has_axis = false,
                      .slides = false,
                      .unit = "rad",
                      .error_unit = "deg",
                      .error_size = kDegree,
                      .counted = 1.0,
                      .printed_error = 0.5,  // arccos(Q . Q') is half the angle between the rotations
                      .columns = kColumns,
                      .velocity_columns = kVelocityColumns,
                      .mjcf = "ball",
                      .urdf = nullptr,
                      .sdf = "ball",
                      .read = read,
                      .cells = cells,
                      .angle = angle,
                      .difference = difference,
                      .error = error,
                      .mean = mean,
                      .between = between,
                      .moved = moved,
                      .rotation = rotation};

}  // namespace simgap::joint_kinds::spherical
