// A resistor in series with the winding.
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::resistance {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "resistance", "ohm", Range{0.0, 1e6, false, "a resistance in [0, 1e6] Ohm"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.kind != ActuatorKind::kMotor) {
    throw ConfigError("found a resistor, expected it of a winding: voltage against current");
  }
  setting.resistance += change.sizes[0];
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"resistance", read, apply};

}  // namespace simgap::log_changes::resistance
