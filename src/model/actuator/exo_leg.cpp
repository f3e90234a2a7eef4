#include "simgap/model/actuator/exo_leg.h"

namespace simgap {
namespace {

constexpr Range kShare{0.0, 1.0, false, "a number from 0 to 1"};
constexpr Range kBend{-2.8, 2.8, false, "an angle within 160 deg of straight"};
constexpr Range kLegRate{1.0, 1e5, false, "a number between 1 and 1e5"};

LegSegment readSegmentOf(const YamlNode& node, double& inertia) {
  LegSegment segment;
  segment.length = node.quantity("length", "m", kPositive);
  segment.centre = node.quantity("centre", "m", kNonNegative);
  segment.mass = node.quantity("mass", "kg", kPositive);
  inertia = node.quantity("inertia", "kg_m2", kPositive);
  return segment;
}

LegTorques readPerJoint(const YamlNode& node, std::string_view stem, std::string_view unit, const Range& range) {
  return {node.at("ankle").quantity(stem, unit, range), node.at("knee").quantity(stem, unit, range)};
}

}  // namespace

ExoLeg readExoLeg(const YamlNode& root) {
  root.at("format").oneOf({"simgap/exo-leg/1"});
  ExoLeg leg;
  leg.name = root.at("name").text();
  leg.leg.shank = readSegmentOf(root.at("shank"), leg.shank_inertia);
  leg.leg.thigh = readSegmentOf(root.at("thigh"), leg.thigh_inertia);
  leg.leg.load = root.quantity("load", "kg", kNonNegative);
  const YamlNode joints = root.at("joints");
  leg.viscous = readPerJoint(joints, "viscous_friction", "Nms", kNonNegative);
  leg.sitting = readPerJoint(joints, "sitting", "rad", kBend);
  leg.assist.limits = readPerJoint(joints, "torque_limit", "Nm", kPositive);
  const YamlNode seat = root.at("seat");
  leg.seat_stiffness = seat.quantity("stiffness", "N_m", kPositive);
  leg.seat_damping = seat.quantity("damping", "Ns_m", kNonNegative);
  const YamlNode user = root.at("user");
  leg.user.strength = user.at("strength").number(kShare);
  leg.user.horizontal_stiffness = user.quantity("horizontal_stiffness", "N_m", kNonNegative);
  leg.user.horizontal_damping = user.quantity("horizontal_damping", "Ns_m", kNonNegative);
  leg.user.horizontal_limit = user.quantity("horizontal_limit", "N", kNonNegative);
  const YamlNode assist = root.at("assist");
  leg.assist.share = assist.at("share").number(kShare);
  leg.assist.rise_time = assist.quantity("rise_time", "s", kPositive);
  leg.rate = assist.findQuantity("rate", "Hz", kLegRate).value_or(leg.rate);
  root.expectAllRead();
  if (leg.leg.hipHeight(leg.sitting[0], leg.sitting[1]) > 0.95 * leg.leg.hipHeight(0.0, 0.0)) {
    joints.fail("found a seat on which the leg stands, expected angles that bend it");
  }
  return leg;
}

}  // namespace simgap
