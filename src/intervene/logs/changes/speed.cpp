// The same motion that many times as fast.
#include "simgap/intervene/logs/log_change.h"

namespace simgap::log_changes::speed {
namespace {

void apply(const LogChange& change, LogSetting& setting) {
  const double factor = change.sizes[0];
  setting.channels["time"] = 1.0 / factor;
  for (const char* channel : {"motor_velocity", "joint_velocity", "velocity"}) setting.channels[channel] = factor;
  if (setting.bench.bandwidth) *setting.bench.bandwidth *= factor;
}

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"speed", readFactor, apply, true};

}  // namespace simgap::log_changes::speed
