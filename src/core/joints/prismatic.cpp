// A slide: a way along an axis that is fixed in both bodies.
#include "one_axis.h"

namespace simgap::joint_kinds::prismatic {
namespace {

constexpr std::string_view kColumns[] = {"_m"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  return readCoordinate(table, joint, "m");
}

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return {to.angle - from.angle, 0.0, 0.0};
}

}  // namespace

extern const JointKind entry;
const JointKind entry{.type = JointType::kPrismatic,
                      .name = "prismatic",
                      .degrees_of_freedom = 1,
                      .has_axis = true,
                      .unit = "m",
                      .error_unit = "mm",
                      .error_size = 1e-3,
                      .counted = 1.0 / kSlideLever,
                      .printed_error = 1.0,
                      .columns = kColumns,
                      .read = read,
                      .cells = coordinateCells,
                      .angle = coordinate,
                      .difference = difference,
                      .mean = meanCoordinate};

}  // namespace simgap::joint_kinds::prismatic
