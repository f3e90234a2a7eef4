// A slide: a way along an axis that is fixed in both bodies.
#include <cmath>

#include "one_axis.h"

namespace simgap::joint_kinds::prismatic {
namespace {

constexpr std::string_view kColumns[] = {"_m"};
constexpr std::string_view kVelocityColumns[] = {"_velocity_m_s"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  return readCoordinate(table, joint, "m");
}

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return {to.angle - from.angle, 0.0, 0.0};
}

double error(const JointPosition& a, const JointPosition& b) { return std::abs(a.angle - b.angle); }

Eigen::Matrix3d rotation(const Eigen::Vector3d& /*axis*/, const JointPosition& /*position*/) {
  return Eigen::Matrix3d::Identity();
}

}  // namespace

extern const JointKind entry;
const JointKind entry{.type = JointType::kPrismatic,
                      .name = "prismatic",
                      .degrees_of_freedom = 1,
                      .has_axis = true,
                      .slides = true,
                      .unit = "m",
                      .error_unit = "mm",
                      .error_size = 1e-3,
                      .counted = 1.0 / kSlideLever,
                      .printed_error = 1.0,
                      .columns = kColumns,
                      .velocity_columns = kVelocityColumns,
                      .mjcf = "slide",
                      .urdf = "prismatic",
                      .sdf = "prismatic",
                      .read = read,
                      .cells = coordinateCells,
                      .angle = coordinate,
                      .difference = difference,
                      .error = error,
                      .mean = meanCoordinate,
                      .between = coordinateBetween,
                      .moved = movedCoordinate,
                      .rotation = rotation};

}  // namespace simgap::joint_kinds::prismatic
