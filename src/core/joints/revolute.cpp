// A hinge: an angle about an axis that is fixed in both bodies.
#include "simgap/core/joint_kind.h"

namespace simgap::joint_kinds {
namespace {

constexpr std::string_view kColumns[] = {"_rad"};

std::vector<JointPosition> read(const CsvTable& table, const std::string& joint) {
  std::vector<JointPosition> positions(table.rows());
  const std::vector<double> angles = table.quantity(joint, "rad");
  for (std::size_t row = 0; row < angles.size(); ++row) positions[row].angle = angles[row];
  return positions;
}

std::vector<double> cells(const JointPosition& position) { return {position.angle}; }

double angle(const JointPosition& position) { return position.angle; }

Eigen::Vector3d difference(const JointPosition& from, const JointPosition& to) {
  return {hingeTurn(from.angle, to.angle), 0.0, 0.0};
}

JointPosition mean(std::span<const JointPosition> repeats) {
  JointPosition mean;
  for (const JointPosition& repeat : repeats) mean.angle += repeat.angle / static_cast<double>(repeats.size());
  return mean;
}

}  // namespace

extern const JointKind revolute;
const JointKind revolute{.type = JointType::kRevolute,
                         .name = "revolute",
                         .degrees_of_freedom = 1,
                         .has_axis = true,
                         .unit = "rad",
                         .printed_error = 1.0,
                         .columns = kColumns,
                         .read = read,
                         .cells = cells,
                         .angle = angle,
                         .difference = difference,
                         .mean = mean};

}  // namespace simgap::joint_kinds
