// The bench tilted: gravity turns in the world's frame, by a rotation vector.
#include "simgap/model/arm/arm_change.h"

namespace simgap::arm_changes::tilt {
namespace {

ArmChange read(const YamlNode& node, const ArmModel& /*model*/) {
  ArmChange change;
  const YamlNode turn = node.at("turn_rad");
  const Eigen::Vector3d w = turn.vector3();
  if (w.norm() > 3.2) turn.fail("expected a rotation of at most pi");
  change.sizes = {w.x(), w.y(), w.z()};
  change.sds.assign(3, node.findQuantity("turn_sd", "rad", kNonNegative).value_or(0.0));
  return change;
}

void apply(const ArmChange& change, ArmModel& model) {
  // The arm and the capture's frame turn with the bench, gravity does not.
  const Eigen::Vector3d w(change.sizes[0], change.sizes[1], change.sizes[2]);
  model.gravity = expSo3(-w) * model.gravity;
}

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"tilt", read, apply};

}  // namespace simgap::arm_changes::tilt
