// Contacts are not modelled: which geoms MuJoCo lets touch each other, so that nobody misses them in silence.
#include "mjcf_robot.h"

namespace simgap {
namespace {

/// The body that carries it and moves: bodies without joints are welded to their parents; -1: the world.
int carrierOf(const MjcfRobot& robot, int body) {
  while (body >= 0 && robot.bodies[body].joints.empty()) body = robot.bodies[body].parent;
  return body;
}

/// Neither geoms of one body nor those of a body and of the one that it hangs on touch, but for the world's.
bool mayTouch(const MjcfRobot& robot, const MjcfGeom& a, const MjcfGeom& b) {
  if ((a.contype & b.conaffinity) == 0 && (b.contype & a.conaffinity) == 0) return false;
  const int one = carrierOf(robot, a.body), other = carrierOf(robot, b.body);
  const auto hangs = [&](int child, int parent) {
    return child >= 0 && parent >= 0 && carrierOf(robot, robot.bodies[child].parent) == parent;
  };
  return one != other && !hangs(one, other) && !hangs(other, one);
}

}  // namespace

void nameContacts(const MjcfRobot& robot, XmlRobot& xml) {
  for (const MjcfGeom& geom : robot.geoms) {
    const auto touches = [&](const MjcfGeom& other) { return mayTouch(robot, geom, other); };
    if (std::ranges::any_of(robot.geoms, touches)) {
      xml.add("contacts of a geom with others", "left out: bodies pass through each other", true, geom.place);
    }
  }
}

}  // namespace simgap
