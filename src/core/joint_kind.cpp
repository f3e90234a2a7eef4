#include "simgap/core/joint_kind.h"

#include <algorithm>

namespace simgap {

const JointKind& kindOf(JointType type) { return **std::ranges::find(joint_kinds::all(), type, &JointKind::type); }

std::vector<std::string> jointTypeNames() {
  std::vector<std::string> names;
  for (const JointKind* kind : joint_kinds::all()) names.emplace_back(kind->name);
  return names;
}

JointType readJointType(const YamlNode& node) { return findKind(&JointKind::name, node.oneOf(jointTypeNames()))->type; }

const JointKind* findKind(const char* JointKind::*format, std::string_view name) {
  const auto found = std::ranges::find_if(
      joint_kinds::all(), [&](const JointKind* kind) { return kind->*format != nullptr && kind->*format == name; });
  return found == joint_kinds::all().end() ? nullptr : *found;
}

double jointError(JointType type, const JointPosition& a, const JointPosition& b) { return kindOf(type).error(a, b); }

std::vector<std::string> positionColumns(JointType type, const std::string& joint) {
  std::vector<std::string> names;
  for (const std::string_view column : kindOf(type).columns) names.push_back(joint + std::string(column));
  return names;
}

}  // namespace simgap
