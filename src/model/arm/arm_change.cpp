#include "simgap/model/arm/arm_change.h"

#include <fmt/format.h>

#include <algorithm>

namespace simgap {
namespace {

template <class Item>
int indexByName(const YamlNode& node, const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return static_cast<int>(std::ranges::find(names, node.oneOf(names)) - names.begin());
}

ArmChange readChange(const YamlNode& node, const ArmModel& model) {
  std::vector<std::string> names;
  for (const ArmChangeKind* kind : arm_changes::all()) names.emplace_back(kind->name);
  const std::string name = node.at("kind").oneOf(names);
  const ArmChangeKind& kind = **std::ranges::find(arm_changes::all(), name, &ArmChangeKind::name);
  ArmChange change = kind.read(node, model);
  change.kind = &kind;
  return change;
}

}  // namespace

int bodyOf(const YamlNode& node, const ArmModel& model) { return indexByName(node, model.bodies); }
int muscleOf(const YamlNode& node, const ArmModel& model) { return indexByName(node, model.muscles); }

ArmChanges ArmChanges::read(const YamlNode& root, const ArmModel& model) {
  const YamlNode format = root.at("format");
  if (format.text() != "simgap/change/1") {
    format.fail(fmt::format("found {}, expected simgap/change/1", format.text()));
  }
  ArmChanges all;
  if (const auto name = root.find("name")) all.name = name->text();
  const YamlNode list = root.at("changes");
  for (const YamlNode& node : list.items()) all.changes.push_back(readChange(node, model));
  if (all.changes.empty()) list.fail("found no change, expected at least one");
  root.expectAllRead();
  return all;
}

void ArmChanges::apply(ArmModel& model) const {
  for (const ArmChange& change : changes) change.kind->apply(change, model);
}

bool ArmChanges::undoes(const std::string& cause) const {
  return std::ranges::find(changes, cause, &ArmChange::cause) != changes.end();
}

std::vector<std::pair<ArmChanges, ArmChanges>> ArmChanges::withinUncertainty() const {
  std::vector<std::pair<ArmChanges, ArmChanges>> pairs;
  for (std::size_t c = 0; c < changes.size(); ++c) {
    for (std::size_t i = 0; i < changes[c].sizes.size(); ++i) {
      const double sd = changes[c].sds[i];
      if (sd <= 0.0) continue;
      auto& [forward, back] = pairs.emplace_back(*this, *this);
      forward.changes[c].sizes[i] += sd;
      back.changes[c].sizes[i] -= sd;
    }
  }
  return pairs;
}

}  // namespace simgap
