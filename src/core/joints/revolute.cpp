// A hinge: an angle about an axis that is fixed in both bodies.
#include <cmath>

#include "one_axis.h"

namespace simgap::joint_kinds::revolute {
namespace {

constexpr std::string_view kColumns[] = {"_rad"};
constexpr std::string_view kVelocityColumns[] = {"_velocity_rad_s"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  return readCoordinate(table, joint, "rad");
}

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return {hingeTurn(from.angle, to.angle), 0.0, 0.0};
}

double error(const JointPosition& a, const JointPosition& b) { return std::abs(hingeTurn(b.angle, a.angle)); }

Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, const JointPosition& position) {
  return Eigen::AngleAxisd(position.angle, axis).toRotationMatrix();
}

}  // namespace

extern const JointKind entry;
const JointKind entry{.type = JointType::kRevolute,
                      .name = "revolute",
                      .degrees_of_freedom = 1,
                      .has_axis = true,
                      .slides = false,
                      .unit = "rad",
                      .error_unit = "deg",
                      .error_size = kDegree,
                      .counted = 1.0,
                      .printed_error = 1.0,
                      .columns = kColumns,
                      .velocity_columns = kVelocityColumns,
                      .mjcf = "hinge",
                      .urdf = "revolute",
                      .sdf = "revolute",
                      .read = read,
                      .cells = coordinateCells,
                      .angle = coordinate,
                      .difference = difference,
                      .error = error,
                      .mean = meanCoordinate,
                      .between = coordinateBetween,
                      .moved = movedCoordinate,
                      .rotation = rotation};

}  // namespace simgap::joint_kinds::revolute
