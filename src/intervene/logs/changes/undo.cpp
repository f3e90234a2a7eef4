// What a cause stands for was taken away: the cable straightened, the weight unscrewed, the sensor zeroed. A model
// that holds the cause loses it; one that explains the same log otherwise stays as it is.
#include <fmt/format.h>

#include <algorithm>

#include "simgap/intervene/logs/log_change.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::log_changes::undo {
namespace {

LogChange read(const YamlNode& node) {
  LogChange change;
  const YamlNode cause = node.at("cause");
  change.cause = cause.text();
  const auto known = [&](const ActuatorEffect* effect) { return effect->name == change.cause; };
  if (!std::ranges::any_of(actuator_effects::all(), known)) {
    cause.fail(fmt::format("found '{}', expected a cause of simgap diagnose", change.cause));
  }
  return change;
}

void apply(const LogChange& change, LogSetting& setting) { setting.undone.push_back(change.cause); }

}  // namespace

extern const LogChangeKind entry;
const LogChangeKind entry{"undo", read, apply};

}  // namespace simgap::log_changes::undo
