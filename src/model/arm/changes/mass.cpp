// A mass hung on a body at a point, or taken off it (below 0).
#include <algorithm>

#include <fmt/format.h>

#include "simgap/core/error.h"
#include "simgap/model/arm/arm_change.h"

namespace simgap::arm_changes::mass {
namespace {

ArmChange read(const YamlNode& node, const ArmModel& model) {
  ArmChange change;
  change.target = bodyOf(node.at("body"), model);
  const YamlNode at = node.at("at_m");
  change.place = at.vector3();
  if (change.place.norm() > 10.0) at.fail("expected a point within 10 m of the body's frame");
  change.sizes = {node.quantity("mass", "kg", Range{-100.0, 100.0, false, "a mass in [-100, 100] kg"})};
  change.sds = {node.findQuantity("mass_sd", "kg", kNonNegative).value_or(0.0)};
  return change;
}

void apply(const ArmChange& change, ArmModel& model) {
  // Into the heaviest part: a part more would be one more parameter of a calibration that takes all masses.
  Body& body = model.bodies[change.target];
  if (body.parts.empty()) {
    throw ConfigError(fmt::format("body {} has no part, expected one that a mass can be added to", body.name));
  }
  Part& part = *std::ranges::max_element(body.parts, {}, &Part::mass);
  const double mass = part.mass + change.sizes[0];
  if (!(mass > 0.0)) {
    throw ConfigError(fmt::format("the change takes {} kg off body {}, whose heaviest part has {:.4g} kg",
                                  -change.sizes[0], body.name, part.mass));
  }
  Part point;
  point.shape = Part::Shape::kSphere;
  point.mass = change.sizes[0];
  point.position = change.place;
  Body both;
  both.parts = {part, point};
  const MassProperties melted = massProperties(both);
  part.position = melted.centre_of_mass;
  part.mass = mass;
  // More than the part has cannot be taken away: a small part may stand for a body whose mass is elsewhere. Rests are
  // right then, too; the inertia stays that of the part.
  if (melted.inertia.llt().info() != Eigen::Success) return;
  part.shape = Part::Shape::kInertia;
  part.inertia = melted.inertia;
}

}  // namespace

extern const ArmChangeKind entry;
const ArmChangeKind entry{"mass", read, apply};

}  // namespace simgap::arm_changes::mass
