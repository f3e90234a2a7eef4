// The pendulum made longer, or shorter (below 0).
#include "intervene/logs/bench_constants.h"
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::length {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "longer", "m", Range{-10.0, 10.0, false, "a length in [-10, 10] m"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.bench.load != BenchLoad::kPendulum) {
    throw ConfigError("found a change of length, expected it on a pendulum only");
  }
  changeConstant(setting, &BenchConstants::length, change.sizes[0], "length");
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"length", read, apply};

}  // namespace simgap::log_changes::length
