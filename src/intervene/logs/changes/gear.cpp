// Another gear: so many times the motor turns per turn of the joint. What rubs is taken to stand on the motor's side.
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap::log_changes::gear {
namespace {

void apply(const LogChange& change, LogSetting& setting) {
  if (!kindOf(setting.kind).is_drive) throw ConfigError("found a change of gear, expected it of a drive");
  setting.gear *= change.sizes[0];
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"gear", readFactor, apply};

}  // namespace simgap::log_changes::gear
