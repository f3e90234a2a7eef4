// The same motion under so many times the load that a sensor shows.
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_change.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap::log_changes::load {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  readSize(node, "factor", "", Range{-100.0, 100.0, false, "a factor in [-100, 100]"}, change);
  return change;
}

void apply(const LogChange& change, LogSetting& setting) {
  if (setting.bench.load != BenchLoad::kTorqueSensor || !kindOf(setting.kind).is_drive) {
    throw ConfigError(
        "found a factor of the load, expected it of a drive whose load is measured; else `mass` or `length`");
  }
  for (const char* channel : {"external_torque", "external_force"}) setting.channels[channel] = change.sizes[0];
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"load", read, apply, true};

}  // namespace simgap::log_changes::load
