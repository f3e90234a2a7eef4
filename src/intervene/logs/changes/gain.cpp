// Another amplifier gain or supply: a unit of effort gives that many times the torque it gave.
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap::log_changes::gain {
namespace {

void apply(const LogChange& change, LogSetting& setting) {
  if (!kindOf(setting.kind).is_drive) {
    throw ConfigError("found a change of gain, expected it of a drive: effort against load");
  }
  setting.strength *= change.sizes[0];
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"gain", readFactor, apply};

}  // namespace simgap::log_changes::gain
