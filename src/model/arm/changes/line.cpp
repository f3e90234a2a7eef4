// A line re-tensioned: let out, or drawn in (below 0).
#include "simgap/model/arm/arm_change.h"

namespace simgap::arm_changes::line {
namespace {

ArmChange read(const YamlNode& node, const ArmModel& model) {
  ArmChange change;
  change.target = muscleOf(node.at("muscle"), model);
  change.sizes = {node.quantity("longer", "m", Range{-1.0, 1.0, false, "a length in [-1, 1] m"})};
  change.sds = {node.findQuantity("longer_sd", "m", kNonNegative).value_or(0.0)};
  return change;
}

void apply(const ArmChange& change, ArmModel& model) {
  model.muscles[change.target].kite_line_length += change.sizes[0];
}

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"line", read, apply};

}  // namespace simgap::arm_changes::line
