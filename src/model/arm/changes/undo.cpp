// What a cause stands for was taken away: the payload off the hand, the bench levelled, the stop unscrewed. A model
// that holds the cause loses it; one that explains the same poses otherwise stays as it is.
#include <fmt/format.h>

#include <algorithm>

#include "simgap/model/arm/arm_change.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_changes::undo {
namespace {

ArmChange read(const YamlNode& node, const ArmModel& model) {
  ArmChange change;
  const YamlNode cause = node.at("cause");
  change.cause = cause.text();
  const std::string name = change.cause.substr(0, change.cause.find(':'));
  const ArmEffect* const effect = findArmEffect(name);
  if (effect == nullptr) cause.fail(fmt::format("found '{}', expected a cause of simgap diagnose", change.cause));
  const std::vector<std::string> targets = effectTargets(*effect, model);
  const std::string target = change.cause.size() > name.size() ? change.cause.substr(name.size() + 1) : "";
  if (std::ranges::find(targets, target) == targets.end()) {
    cause.fail(fmt::format("found '{}', expected {} of something that the model has", change.cause, name));
  }
  return change;
}

void apply(const ArmChange& change, ArmModel& model) {
  for (Extension& extension : model.extensions) {
    if (change.cause != effectLabel(extension.effect, extension.target)) continue;
    const ArmEffect& effect = *findArmEffect(extension.effect);
    for (std::size_t k = 0; k < effect.parameters.size(); ++k) {  // a turn or a shift has several that must be nothing
      if (effect.parameters[k].fitted) extension.parameters[k].value = effect.parameters[k].neutral;
    }
  }
}

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"undo", read, apply};

}  // namespace simgap::arm_changes::undo
