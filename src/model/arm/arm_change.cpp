#include "simgap/model/arm/arm_change.h"

#include <algorithm>

namespace simgap {
namespace {

template <class Item>
int indexByName(const YamlNode& node, const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return static_cast<int>(std::ranges::find(names, node.oneOf(names)) - names.begin());
}

}  // namespace

int bodyOf(const YamlNode& node, const ArmModel& model) { return indexByName(node, model.bodies); }
int muscleOf(const YamlNode& node, const ArmModel& model) { return indexByName(node, model.muscles); }

ArmChanges ArmChanges::read(const YamlNode& root, const ArmModel& model) {
  return readChanges<ArmChanges>(root, arm_changes::all(), model);
}

void ArmChanges::apply(ArmModel& model) const {
  for (const ArmChange& change : changes) change.kind->apply(change, model);
}

bool ArmChanges::undoes(const std::string& cause) const {
  return std::ranges::find(changes, cause, &ArmChange::cause) != changes.end();
}

}  // namespace simgap
