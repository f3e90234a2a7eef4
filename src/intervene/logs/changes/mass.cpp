// A mass put on the pendulum or the linear axis, or taken off it (below 0).
#include "intervene/logs/bench_constants.h"
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::mass {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "mass", "kg", Range{-1000.0, 1000.0, false, "a mass in [-1000, 1000] kg"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.bench.load == BenchLoad::kTorqueSensor) {
    throw ConfigError("found a change of mass on a bench whose load is measured, expected `load`: a factor of it");
  }
  changeConstant(setting, &BenchConstants::mass, change.sizes[0], "mass");
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"mass", read, apply};

}  // namespace simgap::log_changes::mass
