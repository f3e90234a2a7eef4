#include "simgap/model/arm/arm_tree.h"

#include <algorithm>

namespace simgap {

const Joint* jointCarrying(const ArmModel& model, int body) {
  const auto found = std::ranges::find(model.joints, body, &Joint::child);
  return found == model.joints.end() ? nullptr : &*found;
}

std::vector<int> jointsAbove(const ArmModel& model, int body) {
  std::vector<int> joints;
  for (const Joint* joint = jointCarrying(model, body); joint; joint = jointCarrying(model, joint->parent)) {
    joints.push_back(static_cast<int>(joint - model.joints.data()));
  }
  return joints;
}

}  // namespace simgap
