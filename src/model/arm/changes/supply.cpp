// The motors hung on another supply: of one muscle, or of all where none is named. Only what moves shows it.
#include <algorithm>

#include "simgap/model/arm/arm_change.h"

namespace simgap::arm_changes::supply {
namespace {

constexpr int kAll = -1;

ArmChange read(const YamlNode& node, const ArmModel& model) {
  ArmChange change;
  const auto muscle = node.find("muscle");
  change.target = muscle ? muscleOf(*muscle, model) : kAll;
  change.sizes = {node.quantity("voltage", "V", Range{0.0, 1000.0, true, "a voltage in (0, 1000] V"})};
  change.sds = {node.findQuantity("voltage_sd", "V", kNonNegative).value_or(0.0)};
  return change;
}

void apply(const ArmChange& change, ArmModel& model) {
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    const bool meant = change.target == kAll || change.target == static_cast<int>(m);
    if (meant) model.muscles[m].motor.supply_voltage = std::max(0.0, change.sizes[0]);
  }
}

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"supply", read, apply};

}  // namespace simgap::arm_changes::supply
