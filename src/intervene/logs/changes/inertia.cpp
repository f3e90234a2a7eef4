// A disc put on the shaft, or taken off it (below 0).
#include "intervene/logs/bench_constants.h"
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::inertia {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "inertia", "kg_m2", Range{-1000.0, 1000.0, false, "an inertia in [-1000, 1000] kg m2"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.bench.load == BenchLoad::kTorqueSensor) {
    throw ConfigError(
        "found a change of inertia on a bench whose load is measured, expected it on a pendulum or a free axis");
  }
  changeConstant(setting, &BenchConstants::inertia, change.sizes[0], "inertia");
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"inertia", read, apply};

}  // namespace simgap::log_changes::inertia
