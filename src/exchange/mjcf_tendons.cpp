// <tendon>, <equality>: the ways of lines, and what ties joints together.
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "mjcf_robot.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kMostTendons = 2000;

std::string required(const MjcfNode& node, const char* attribute) {
  if (!node.has(attribute)) node.fail(fmt::format("found no {}, expected one", attribute));
  return node.text(attribute);
}

MjcfPathElement pathElement(const MjcfNode& node, const MjcfRobot& robot) {
  MjcfPathElement element;
  const auto site = [&](const std::string& name) {
    if (!robot.sites.contains(name)) {
      node.fail(fmt::format("found '{}', expected the name of a site", abridged(name)));
    }
    return name;
  };
  if (node.tag() == "site") {
    element.name = site(required(node, "site"));
  } else if (node.tag() == "geom") {
    element.kind = MjcfPathElement::Kind::kSurface;
    element.name = required(node, "geom");
    if (!robot.surfaces.contains(element.name)) {
      node.fail(fmt::format("geom: found '{}', expected the name of a sphere or cylinder", abridged(element.name)));
    }
    if (node.has("sidesite")) element.side = site(node.text("sidesite"));
  } else {
    element.kind = MjcfPathElement::Kind::kPulley;
    element.divisor = node.number("divisor", 0.0);
    if (element.divisor <= 0.0) node.fail(fmt::format("divisor: found {}, expected > 0", element.divisor));
  }
  return element;
}

/// Two points at least, a point before and behind every surface, and branches of two points or more.
void checkPath(const MjcfNode& node, const std::vector<MjcfPathElement>& path) {
  int points = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto is_site = [&](std::size_t k) { return k < path.size() && path[k].kind == MjcfPathElement::Kind::kSite; };
    if (path[i].kind == MjcfPathElement::Kind::kSurface && !(i > 0 && is_site(i - 1) && is_site(i + 1))) {
      node.fail(fmt::format("found the geom '{}' without a site before and behind it", path[i].name));
    }
    if (path[i].kind == MjcfPathElement::Kind::kSite) ++points;
    const bool ends = i + 1 == path.size() || path[i + 1].kind == MjcfPathElement::Kind::kPulley;
    if (ends && points < 2) {
      node.fail(fmt::format("found a path of {} sites, expected at least two{}", points,
                            points == 0 ? "" : " in each branch"));
    }
    if (ends) points = 0;
  }
  if (path.empty()) node.fail("found no site, expected at least two");
}

void readTendonLaw(const MjcfNode& node, MjcfTendon& tendon) {
  tendon.stiffness = node.nonNegative("stiffness", 0.0);
  tendon.damping = node.nonNegative("damping", 0.0);
  tendon.friction_loss = node.nonNegative("frictionloss", 0.0);
  const std::vector<double> rest = node.numbers("springlength");
  if (rest.size() > 2) node.fail(fmt::format("springlength: found {} numbers, expected one or two", rest.size()));
  if (!rest.empty() && rest[0] >= 0.0) tendon.spring_length = {rest[0], rest.back()};
  if (rest.size() == 2 && rest[0] > rest[1]) {
    node.fail(fmt::format("springlength: found {} above {}", rest[0], rest[1]));
  }
  tendon.range = node.limits("limited", "range");
  if (node.number("armature", 0.0) != 0.0) {
    node.remark("armature", "left out: a line has no mass (motions only, not where the robot rests)");
  }
  for (const char* limit : {"actuatorfrcrange", "actuatorfrclimited"}) {
    if (node.has(limit)) node.remark(limit, "left out: no limit of a line's force");
  }
}

MjcfTendon readTendon(MjcfFile& file, const MjcfNode& node, const MjcfRobot& robot) {
  MjcfTendon tendon;
  tendon.name = node.newName("tendon");
  tendon.place = file.xml().place(node.xml());
  for (const MjcfNode& child : node.children()) {
    const std::string tag = child.tag();
    if (node.tag() == "fixed" && tag == "joint") {
      tendon.joints.emplace_back(required(child, "joint"), child.number("coef", 0.0));
    } else if (node.tag() == "spatial" && (tag == "site" || tag == "geom" || tag == "pulley")) {
      tendon.path.push_back(pathElement(child, robot));
    } else {
      child.fail(fmt::format("found it in <{}>, expected what a tendon runs over", node.tag()));
    }
  }
  // A wheel of radius 0, which ours cannot have, changes no length.
  const auto acts = [](const auto& wheel) { return wheel.second != 0.0; };
  if (std::ranges::any_of(tendon.joints, acts)) std::erase_if(tendon.joints, std::not_fn(acts));
  if (node.tag() == "spatial") checkPath(node, tendon.path);
  if (node.tag() == "fixed" && tendon.joints.empty()) node.fail("found no joint, expected at least one");
  readTendonLaw(node, tendon);
  return tendon;
}

/// Whether a tendon runs over something that is left out with a loose body.
bool runsToLoose(const MjcfNode& node, const MjcfRobot& robot) {
  const std::vector<MjcfNode> path = node.children();
  return std::ranges::any_of(path, [&](const MjcfNode& element) {
    const std::string tag = element.tag();
    return robot.loose.contains(tag + " " + element.text(tag.c_str())) ||
           robot.loose.contains("site " + element.text("sidesite"));
  });
}

void readEquality(MjcfFile& file, const MjcfNode& node, MjcfRobot& robot) {
  node.find("name");
  if (!node.flag("active", true)) return node.remarkAll(node.tag() + " (equality)", "not active: left out", false);
  const std::string tag = node.tag();
  for (const char* const end : {"body1", "body2"}) {
    if (robot.loose.contains("body " + node.text(end))) {
      return node.remarkAll(tag + " (equality)", "left out with the loose body that it holds");
    }
  }
  if (tag == "connect" || tag == "weld") {
    node.fail("found a closed loop, expected a tree of bodies: take it apart at this place");
  }
  if (tag != "joint") return node.remarkAll(tag + " (equality)", "not understood, left out");
  std::vector<double> curve = node.numbers("polycoef");
  if (curve.size() > 5) node.fail(fmt::format("polycoef: found {} numbers, expected at most 5", curve.size()));
  const std::array<double, 5> usual = {0.0, 1.0, 0.0, 0.0, 0.0};
  for (std::size_t i = curve.size(); i < usual.size(); ++i) curve.push_back(usual[i]);
  const bool straight = curve[2] == 0.0 && curve[3] == 0.0 && curve[4] == 0.0;
  if (node.has("joint2") && !straight) {
    return node.remarkAll("joint (equality) along a curve (polycoef)",
                          "the whole coupling is left out: joints are coupled along straight lines only");
  }
  robot.couplings.push_back({required(node, "joint1"), node.text("joint2"), curve[0],
                             node.has("joint2") ? curve[1] : 0.0, file.xml().place(node.xml())});
}

}  // namespace

void readMjcfTendons(MjcfFile& file, MjcfRobot& robot) {
  for (const MjcfNode& section : file.sections("tendon")) {
    for (const MjcfNode& node : section.children()) {
      if (node.tag() != "spatial" && node.tag() != "fixed") node.fail("found it, expected <spatial> or <fixed>");
      if (robot.tendons.size() >= kMostTendons) node.fail(fmt::format("found more than {} tendons", kMostTendons));
      if (runsToLoose(node, robot)) {
        if (node.has("name")) robot.loose.insert("tendon " + node.newName("tendon"));
        node.remarkAll(node.tag() + " (tendon)", "left out: it runs to a loose body that is left out");
        continue;
      }
      robot.tendons.push_back(readTendon(file, node, robot));
    }
  }
  for (const MjcfNode& section : file.sections("equality")) {
    for (const MjcfNode& node : section.children()) readEquality(file, node, robot);
  }
}

MjcfRobot readMjcfRobot(MjcfFile& file) {
  MjcfRobot robot;
  robot.name = file.modelName();
  for (const MjcfNode& option : file.sections("option")) {
    robot.gravity = option.vector3("gravity", robot.gravity);
    for (const char* medium : {"density", "viscosity", "wind", "magnetic"}) {
      if (option.has(medium)) option.remark(medium, "left out: no air and no field acts on bodies");
    }
    bool none = false;
    for (const MjcfNode& flag : option.children()) {
      none = none || flag.text("gravity") == "disable";
      if (flag.has("filterparent")) robot.neighbours_touch = flag.text("filterparent") == "disable";
      robot.contacts = robot.contacts && flag.text("contact") != "disable" && flag.text("constraint") != "disable";
      for (const char* part :
           {"constraint", "equality", "limit", "spring", "damper", "passive", "actuation", "frictionloss"}) {
        if (flag.text(part) == "disable") flag.remark(part, "left out: what the model states acts");
      }
    }
    if (none) robot.gravity.setZero();
    option.remarkAll("option", "how MuJoCo solves, not what: left out but for gravity", false);
  }
  readMjcfBodies(file, robot);
  if (robot.contacts) nameContacts(file, robot);
  readMjcfTendons(file, robot);
  readMjcfActuators(file, robot);
  nameMjcfParts(robot, file.xml());
  return robot;
}

}  // namespace simgap
