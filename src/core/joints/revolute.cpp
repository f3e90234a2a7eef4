// A hinge: an angle about an axis that is fixed in both bodies.
#include "one_axis.h"

namespace simgap::joint_kinds::revolute {
namespace {

constexpr std::string_view kColumns[] = {"_rad"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  return readCoordinate(table, joint, "rad");
}

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return {hingeTurn(from.angle, to.angle), 0.0, 0.0};
}

}  // namespace

extern const JointKind entry;
const JointKind entry{.type = JointType::kRevolute,
                      .name = "revolute",
                      .degrees_of_freedom = 1,
                      .has_axis = true,
                      .unit = "rad",
                      .error_unit = "deg",
                      .error_size = kDegree,
                      .counted = 1.0,
                      .printed_error = 1.0,
                      .columns = kColumns,
                      .read = read,
                      .cells = coordinateCells,
                      .angle = coordinate,
                      .difference = difference,
                      .mean = meanCoordinate};

}  // namespace simgap::joint_kinds::revolute
