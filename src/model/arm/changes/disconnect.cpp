// A muscle taken off its bone: its line is slack in every pose.
#include "simgap/model/arm/arm_change.h"

namespace simgap::arm_changes::disconnect {
namespace {

constexpr double kSlack = 10.0;  // [m]

ArmChange read(const YamlNode& node, const ArmModel& model) {
  ArmChange change;
  change.target = muscleOf(node.at("muscle"), model);
  return change;
}

void apply(const ArmChange& change, ArmModel& model) { model.muscles[change.target].kite_line_length += kSlack; }

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"disconnect", read, apply};

}  // namespace simgap::arm_changes::disconnect
