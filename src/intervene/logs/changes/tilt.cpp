// The bench tilted about the axis of its pendulum: the reading at which it hangs down moves by that much.
#include "intervene/logs/bench_constants.h"
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::tilt {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "turn", "rad", Range{-3.2, 3.2, false, "an angle in [-3.2, 3.2] rad"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.bench.load != BenchLoad::kPendulum) {
    throw ConfigError("found a tilt, expected it on a pendulum only: a torque sensor shows what comes of it");
  }
  changeConstant(setting, &BenchConstants::angle_offset, change.sizes[0], "angle_offset");
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"tilt", read, apply};

}  // namespace simgap::log_changes::tilt
