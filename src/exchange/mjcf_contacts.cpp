// Contacts are not modelled: which geoms MuJoCo lets touch each other, so that nobody misses them in silence.
#include <algorithm>
#include <compare>
#include <set>

#include "mjcf_robot.h"

namespace simgap {
namespace {

/// Geoms of one body that ask alike are alike here.
struct Touching {
  int body = -1, hangs_on = -1;  ///< bodies that move; -1: the world
  std::int64_t contype = 0, conaffinity = 0;
  auto operator<=>(const Touching&) const = default;
};

Touching touchingOf(const MjcfRobot& robot, const MjcfGeom& geom) {
  const int body = carrierOf(robot, geom.body);
  const int hangs_on = body < 0 ? -1 : carrierOf(robot, robot.bodies[body].parent);
  return {body, hangs_on, geom.contype, geom.conaffinity};
}

/// Neither geoms of one body nor those of a body and of the one that it hangs on touch, but for the world's.
bool mayTouch(const Touching& a, const Touching& b) {
  const auto hangs = [](const Touching& child, const Touching& on) {
    return child.body >= 0 && on.body >= 0 && child.hangs_on == on.body;
  };
  const bool asked = (a.contype & b.conaffinity) != 0 || (b.contype & a.conaffinity) != 0;
  return asked && a.body != b.body && !hangs(a, b) && !hangs(b, a);
}

}  // namespace

int carrierOf(const MjcfRobot& robot, int body) {
  while (body >= 0 && robot.bodies[body].joints.empty()) body = robot.bodies[body].parent;
  return body;
}

void nameContacts(const MjcfRobot& robot, XmlRobot& xml) {
  constexpr std::size_t kMostKinds = 2000;  // beyond them none is spared a remark
  std::set<Touching> kinds;
  for (const MjcfGeom& geom : robot.geoms) kinds.insert(touchingOf(robot, geom));
  std::set<Touching> touching;
  for (const Touching& kind : kinds) {
    const auto meets = [&](const Touching& other) { return mayTouch(kind, other); };
    if (kinds.size() > kMostKinds || std::ranges::any_of(kinds, meets)) touching.insert(kind);
  }
  for (const MjcfGeom& geom : robot.geoms) {
    if (!touching.contains(touchingOf(robot, geom))) continue;
    xml.add("contacts of a geom with others", "left out: bodies pass through each other", true, geom.place);
  }
}

}  // namespace simgap
