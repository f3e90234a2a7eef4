// What the parts of an MJCF file are called in the arm: a name that the file gives is kept, one that it does not give
// is made up so that it takes no given one, and what cannot be kept is remarked.
#include <fmt/format.h>

#include <algorithm>

#include "mjcf_robot.h"

namespace simgap {
namespace {

const JointKind* kindOfJoint(const MjcfRobot& robot, const std::string& said) {
  for (const MjcfBody& body : robot.bodies) {
    const auto joint = std::ranges::find(body.joints, said, &MjcfJoint::said);
    if (joint != body.joints.end()) return joint->kind;
  }
  return nullptr;
}

/// Muscles, passive lines and drives of joints share their names.
void nameLines(MjcfRobot& robot, XmlRobot& xml) {
  std::vector<NameWish> wishes;
  for (MjcfTendon& tendon : robot.tendons) {
    wishes.push_back({&tendon.line, "tendon", tendon.name, tendon.place, "tendon"});
    const bool pulled = !tendon.name.empty() &&
                        std::ranges::find(robot.actuators, tendon.name, &MjcfActuator::tendon) != robot.actuators.end();
    if (pulled && tendon.stiffness > 0.0) wishes.push_back({&tendon.beside, "tendon", "", tendon.place, tendon.name});
  }
  for (MjcfActuator& actuator : robot.actuators) {
    const JointKind* const kind = actuator.tendon.empty() ? kindOfJoint(robot, actuator.joint) : nullptr;
    if (kind == nullptr || !notDriven(actuator, *kind).empty()) continue;
    wishes.push_back({&actuator.drive, "actuator", actuator.name, actuator.place, actuator.joint});
  }
  std::set<std::string> taken;
  giveNames(wishes, taken, xml);
}

/// Those that a line runs over: others do not come into the arm.
void nameSurfaces(MjcfRobot& robot, XmlRobot& xml) {
  std::vector<NameWish> wishes;
  for (auto& [said, surface] : robot.surfaces) {
    const bool used = std::ranges::any_of(robot.tendons, [&said = said](const MjcfTendon& tendon) {
      return std::ranges::any_of(tendon.path, [&](const MjcfPathElement& element) {
        return element.kind == MjcfPathElement::Kind::kSurface && element.name == said;
      });
    });
    if (used) wishes.push_back({&surface.name, "geom", said, surface.place, ""});
  }
  std::set<std::string> taken;
  giveNames(wishes, taken, xml);
}

}  // namespace

void nameMjcfParts(MjcfRobot& robot, XmlRobot& xml) {
  std::vector<NameWish> bodies, joints;
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) {
    MjcfBody& body = robot.bodies[i];
    bodies.push_back({&body.name, "body", body.said, body.place, fmt::format("body_{}", i + 1)});
  }
  std::set<std::string> taken_bodies = {"world"}, taken_joints;
  giveNames(bodies, taken_bodies, xml);
  for (MjcfBody& body : robot.bodies) {
    for (MjcfJoint& joint : body.joints) {
      joints.push_back({&joint.name, "joint", joint.said, joint.place, body.name + "_joint"});
    }
  }
  giveNames(joints, taken_joints, xml);
  nameLines(robot, xml);
  nameSurfaces(robot, xml);
}

}  // namespace simgap
