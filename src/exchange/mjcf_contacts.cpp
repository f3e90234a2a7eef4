// Contacts are not modelled: which geoms MuJoCo lets touch each other, so that nobody misses them in silence.
#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <set>
#include <string>
#include <utility>

#include "mjcf_robot.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

/// Geoms of one body that ask alike are alike here.
struct Touching {
  std::string said;              ///< the file's body that they stand in
  int body = -1, hangs_on = -1;  ///< bodies that move; -1: the world
  std::int64_t contype = 0, conaffinity = 0;
  auto operator<=>(const Touching&) const = default;
};

Touching touchingOf(const MjcfRobot& robot, const MjcfGeom& geom) {
  const int body = carrierOf(robot, geom.body);
  const int hangs_on = body < 0 ? -1 : carrierOf(robot, robot.bodies[body].parent);
  return {geom.body < 0 ? "world" : robot.bodies[geom.body].said, body, hangs_on, geom.contype, geom.conaffinity};
}

/// What <contact> says about geoms that meet.
struct ContactRules {
  std::set<std::pair<std::string, std::string>> excluded;  ///< bodies, either way round
  std::set<std::string> paired;                            ///< geoms that touch whatever else is said
};

/// What the element names, as MuJoCo demands. \throws DataError: nothing has that name
std::string named(const MjcfNode& node, const char* attribute, const std::set<std::string>& names, const char* what) {
  std::string name = node.text(attribute);
  if (!names.contains(name)) {
    node.fail(fmt::format("{}: found '{}', expected the name of a {}", attribute, abridged(name), what));
  }
  return name;
}

ContactRules rulesOf(MjcfFile& file, const MjcfRobot& robot) {
  std::set<std::string> bodies = {"world"}, geoms;
  for (const MjcfBody& body : robot.bodies) bodies.insert(body.said);
  for (const MjcfGeom& geom : robot.geoms) geoms.insert(geom.name);
  bodies.erase("");
  geoms.erase("");
  ContactRules rules;
  for (const MjcfNode& section : file.sections("contact")) {
    for (const MjcfNode& node : section.children()) {
      if (node.tag() == "exclude") {
        const std::string a = named(node, "body1", bodies, "body"), b = named(node, "body2", bodies, "body");
        rules.excluded.insert({{a, b}, {b, a}});
      } else {
        for (const char* const end : {"geom1", "geom2"}) rules.paired.insert(named(node, end, geoms, "geom"));
      }
      node.remarkAll(node.tag() + " (contact)", "looked at for what may touch, left out", false);
    }
  }
  return rules;
}

/// Geoms of one body never touch, those of a body and of the one that it hangs on seldom, but for the world's.
bool mayTouch(const Touching& a, const Touching& b, const ContactRules& rules, bool neighbours) {
  const auto hangs = [](const Touching& child, const Touching& on) {
    return child.body >= 0 && on.body >= 0 && child.hangs_on == on.body;
  };
  const bool asked = (a.contype & b.conaffinity) != 0 || (b.contype & a.conaffinity) != 0;
  return asked && a.body != b.body && !rules.excluded.contains({a.said, b.said}) &&
         (neighbours || (!hangs(a, b) && !hangs(b, a)));
}

}  // namespace

int carrierOf(const MjcfRobot& robot, int body) {
  while (body >= 0 && robot.bodies[body].joints.empty()) body = robot.bodies[body].parent;
  return body;
}

void nameContacts(MjcfFile& file, const MjcfRobot& robot) {
  constexpr std::size_t kMostKinds = 2000;  // beyond them none is spared a remark
  const ContactRules rules = rulesOf(file, robot);
  std::set<Touching> kinds;
  for (const MjcfGeom& geom : robot.geoms) kinds.insert(touchingOf(robot, geom));
  std::set<Touching> touching;
  for (const Touching& kind : kinds) {
    const auto meets = [&](const Touching& other) { return mayTouch(kind, other, rules, robot.neighbours_touch); };
    if (kinds.size() > kMostKinds || std::ranges::any_of(kinds, meets)) touching.insert(kind);
  }
  for (const MjcfGeom& geom : robot.geoms) {
    if (!touching.contains(touchingOf(robot, geom)) && !rules.paired.contains(geom.name)) continue;
    file.xml().add("contacts of a geom with others", "left out: bodies pass through each other", true, geom.place);
  }
}

}  // namespace simgap
