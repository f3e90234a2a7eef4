// Joints of an arm file, and the tree that they make.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "arm_yaml_parts.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"

namespace simgap::arm_yaml {
namespace {

/// A joint of the file: one that moves, or a weld.
struct Entry {
  Joint joint;
  bool fixed = false;
  std::string leader;  ///< empty: none
  YamlNode node;
};

int bodyIndex(const YamlNode& node, const std::vector<Body>& bodies) {
  const std::string name = node.text();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return static_cast<int>(i);
  }
  node.fail(fmt::format("found '{}', expected the name of a body", name));
}

void readLimits(const YamlNode& node, Joint& joint) {
  const std::string unit(jointUnit(joint, "rad"));
  joint.axis = readAxis(node.at("axis"));
  joint.lower_limit = node.findQuantity("lower_limit", unit).value_or(-Joint::kUnlimited);
  joint.upper_limit = node.findQuantity("upper_limit", unit).value_or(Joint::kUnlimited);
  if (joint.lower_limit > joint.upper_limit) {
    node.fail(
        fmt::format("lower_limit_{} {} is above upper_limit_{} {}", unit, joint.lower_limit, unit, joint.upper_limit));
  }
}

void readStop(const YamlNode& node, Joint& joint) {
  if (joint.hasAxis())
    node.fail("expected lower_limit and upper_limit: swing and twist are those of a spherical joint");
  joint.axis = readAxis(node.at("axis"));
  const Range angle{0.0, std::numbers::pi, true, "an angle between 0 and pi"};
  BallStop& stop = joint.stop;
  stop.swing = node.findQuantity("swing", "rad", angle).value_or(stop.swing);
  stop.lower_twist = node.findQuantity("lower_twist", "rad").value_or(stop.lower_twist);
  stop.upper_twist = node.findQuantity("upper_twist", "rad").value_or(stop.upper_twist);
  if (stop.lower_twist > stop.upper_twist) {
    node.fail(fmt::format("lower_twist_rad {} is above upper_twist_rad {}", stop.lower_twist, stop.upper_twist));
  }
  if (stop.swing > angle.upper && stop.lower_twist < -angle.upper && stop.upper_twist > angle.upper) {
    node.fail("found no limit, expected swing_rad, lower_twist_rad or upper_twist_rad");
  }
  stop.stiffness = node.quantity("stiffness", "Nm_rad", kPositive);
}

/// What `simgap/arm/2` adds to a joint that moves.
void readSpringAndLeader(Entry& entry) {
  Joint& joint = entry.joint;
  if (const auto spring = entry.node.find("spring")) {
    joint.spring_stiffness = spring->quantity("stiffness", jointUnit(joint, "Nm_rad"), kPositive);
    if (joint.hasAxis()) joint.spring_rest = spring->findQuantity("rest", jointUnit(joint, "rad")).value_or(0.0);
  }
  if (const auto limits = entry.node.find("limits")) readStop(*limits, joint);
  if (const auto follows = entry.node.find("follows")) {
    if (!joint.hasAxis()) follows->fail("a spherical joint follows no other: expected a revolute or prismatic one");
    entry.leader = follows->at("joint").text();
    joint.coupling_ratio = follows->at("ratio").number();
    joint.coupling_offset = follows->findQuantity("offset", jointUnit(joint, "rad")).value_or(0.0);
    if (joint.coupling_ratio == 0.0) follows->at("ratio").fail("found 0, expected another number: 0 holds the joint");
  }
}

Entry readJoint(const YamlNode& node, const std::vector<Body>& bodies, std::set<std::string>& names,
                bool second_version) {
  Entry entry{{}, false, "", node};
  Joint& joint = entry.joint;
  joint.name = readName(node, names);
  std::vector<std::string> types = jointTypeNames();
  if (second_version) types.emplace_back("fixed");
  const JointKind* kind = findKind(&JointKind::name, node.at("type").oneOf(types));
  entry.fixed = kind == nullptr;
  if (kind != nullptr) joint.type = kind->type;
  if (!second_version && joint.slides()) node.at("type").fail("a prismatic joint needs 'format: simgap/arm/2'");
  joint.parent = bodyIndex(node.at("parent"), bodies);
  joint.child = bodyIndex(node.at("child"), bodies);
  joint.parent_position = node.vectorQuantity("parent_position", "m");
  joint.child_position = node.vectorQuantity("child_position", "m");
  if (second_version) {
    joint.parent_orientation = readOrientation(node, "parent_");
    joint.child_orientation = readOrientation(node, "child_");
  }
  if (entry.fixed) return entry;
  if (joint.hasAxis()) readLimits(node, joint);
  joint.coulomb_friction = node.findQuantity("coulomb_friction", jointUnit(joint, "Nm"), kNonNegative).value_or(0.0);
  joint.viscous_friction = node.findQuantity("viscous_friction", jointUnit(joint, "Nms"), kNonNegative).value_or(0.0);
  if (second_version) readSpringAndLeader(entry);
  return entry;
}

/// Orders the joints from the fixed bodies outwards and refuses anything that is not a forest rooted in fixed bodies.
std::vector<Entry> sortedTree(const std::vector<Entry>& entries, const std::vector<Body>& bodies,
                              const YamlNode& joints) {
  std::vector<Entry> sorted;
  std::vector<bool> reached(bodies.size());
  std::vector<int> parents(bodies.size(), 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) reached[i] = bodies[i].fixed;
  for (const auto& [joint, fixed, leader, node] : entries) {
    if (bodies[joint.child].fixed) {
      joints.fail(fmt::format("joint '{}' moves the fixed body '{}'", joint.name, bodies[joint.child].name));
    }
    if (++parents[joint.child] > 1) {
      joints.fail(fmt::format("body '{}' is the child of two joints, expected one: closed loops are not modelled",
                              bodies[joint.child].name));
    }
  }
  std::vector<Entry> waiting = entries;
  for (bool progress = true; progress && !waiting.empty();) {
    progress = false;
    std::vector<Entry> still;
    for (Entry& entry : waiting) {
      if (!reached[entry.joint.parent]) {
        still.push_back(std::move(entry));
        continue;
      }
      reached[entry.joint.child] = true;
      sorted.push_back(std::move(entry));
      progress = true;
    }
    waiting = std::move(still);
  }
  const Body* in_circle = nullptr;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (reached[i]) continue;
    if (parents[i] == 0) {
      joints.fail(fmt::format(
          "body '{}' is not connected to a fixed body by joints: a base that floats is not modelled", bodies[i].name));
    }
    in_circle = &bodies[i];
  }
  if (in_circle != nullptr) {
    joints.fail(
        fmt::format("body '{}' hangs on a circle of joints, expected a tree from a fixed body", in_circle->name));
  }
  return sorted;
}

/// Everything of a body becomes part of another, where it stands still.
void weld(const Body& body, const Place& place, Body& onto) {
  const auto freeName = [&](const std::string& wanted, const auto& items) {
    const auto taken = [&](const std::string& name) {
      return std::any_of(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
    };
    std::string name = wanted;
    while (taken(name)) name.insert(0, body.name + "_");
    return name;
  };
  const Eigen::Quaterniond turn(place.pose.linear());
  for (Part part : body.parts) {
    part.name = freeName(part.name, onto.parts);
    part.position = place.pose * part.position;
    // What a shape has no use for stays as it is: a written model reads back as the same.
    if (part.shape == Part::Shape::kCylinder || part.shape == Part::Shape::kCapsule) part.axis = turn * part.axis;
    if (part.shape == Part::Shape::kBox || part.shape == Part::Shape::kEllipsoid) {
      part.orientation = turn * part.orientation;
    }
    part.inertia = place.pose.linear() * part.inertia * place.pose.linear().transpose();
    onto.parts.push_back(part);
  }
  for (Surface surface : body.surfaces) {
    surface.name = freeName(surface.name, onto.surfaces);
    surface.position = place.pose * surface.position;
    if (surface.shape == Surface::Shape::kCylinder) surface.axis = turn * surface.axis;
    onto.surfaces.push_back(surface);
  }
}

Places placesOf(const std::vector<Body>& bodies) {
  Places places;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    Place& place = places[bodies[b].name];
    place.body = static_cast<int>(b);
    for (const Surface& surface : bodies[b].surfaces) place.surfaces.push_back(surface.name);
  }
  return places;
}

/// Welds the children of fixed joints to their parents, and numbers bodies anew. `entries` in the order of the tree.
void weldFixed(std::vector<Entry>& entries, std::vector<Body>& bodies, Places& places) {
  std::vector<bool> gone(bodies.size());
  const std::vector<Body> before = bodies;
  for (auto& [joint, fixed, leader, node] : entries) {
    const Place& parent = places.at(before[joint.parent].name);
    joint.parent_position = parent.pose * joint.parent_position;
    joint.parent_orientation = Eigen::Quaterniond(parent.pose.linear()) * joint.parent_orientation;
    joint.parent = parent.body;
    if (!fixed) continue;
    Place& child = places.at(before[joint.child].name);
    const Eigen::Quaterniond turn = joint.parent_orientation * joint.child_orientation.conjugate();
    child.pose = Eigen::Translation3d(joint.parent_position) * turn * Eigen::Translation3d(-joint.child_position);
    child.body = joint.parent;
    child.first_surface = static_cast<int>(bodies[joint.parent].surfaces.size());
    weld(before[joint.child], child, bodies[joint.parent]);
    gone[joint.child] = true;
  }
  std::erase_if(entries, [](const Entry& entry) { return entry.fixed; });
  std::vector<int> number(bodies.size(), 0);
  std::vector<Body> left;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    number[b] = static_cast<int>(left.size());
    if (!gone[b]) left.push_back(bodies[b]);
  }
  bodies = std::move(left);
  for (auto& [name, place] : places) place.body = number[place.body];
  for (Entry& entry : entries) {
    entry.joint.parent = number[entry.joint.parent];
    entry.joint.child = number[entry.joint.child];
  }
}

/// The joint that an entry follows.
std::size_t leaderOf(const Entry& entry, const std::vector<Joint>& joints) {
  const YamlNode node = entry.node.at("follows").at("joint");
  const auto found = std::ranges::find(joints, entry.leader, &Joint::name);
  if (found == joints.end()) node.fail(fmt::format("found '{}', expected the name of a joint", entry.leader));
  if (!found->hasAxis()) node.fail(fmt::format("'{}' is spherical, expected a joint with one axis", entry.leader));
  return static_cast<std::size_t>(found - joints.begin());
}

/// Finds the leaders by name. A joint that follows one that follows goes with the free one at the end of that chain,
/// q = o_1 + r_1 (o_2 + r_2 q_free); its limits become limits of that one.
void couple(const std::vector<Entry>& entries, std::vector<Joint>& joints) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (entries[j].leader.empty()) continue;
    const YamlNode node = entries[j].node.at("follows");
    Joint& joint = joints[j];
    std::size_t leader = leaderOf(entries[j], joints);
    for (std::size_t links = 0; !entries[leader].leader.empty(); ++links) {
      if (links == joints.size()) {
        node.at("joint").fail(
            fmt::format("'{}' leads back to itself, expected a chain that ends at a joint that moves "
                        "freely",
                        joint.name));
      }
      const Joint& between = entries[leader].joint;
      joint.coupling_offset += joint.coupling_ratio * between.coupling_offset;
      joint.coupling_ratio *= between.coupling_ratio;
      leader = leaderOf(entries[leader], joints);
    }
    joint.leader = static_cast<int>(leader);
    Joint& free = joints[leader];
    for (const bool of_lower : {true, false}) {
      const double limit = of_lower ? joint.lower_limit : joint.upper_limit;
      if (std::abs(limit) >= Joint::kUnlimited) continue;
      const double of_leader = (limit - joint.coupling_offset) / joint.coupling_ratio;
      const bool lower = of_lower == (joint.coupling_ratio > 0.0);
      if (lower) free.lower_limit = std::max(free.lower_limit, of_leader);
      if (!lower) free.upper_limit = std::min(free.upper_limit, of_leader);
    }
    if (free.lower_limit > free.upper_limit) {
      node.fail(
          fmt::format("the limits of '{}' and of '{}', which it follows, leave no position", joint.name, free.name));
    }
  }
}

}  // namespace

std::string readName(const YamlNode& node, std::set<std::string>& taken) {
  const YamlNode at = node.at("name");
  std::string name = at.text();
  if (name.empty() || name.find_first_of(".*,") != std::string::npos) {
    at.fail(fmt::format("found '{}', expected a name without '.', '*' or ','", name));
  }
  if (!taken.insert(name).second) at.fail(fmt::format("the name '{}' is taken", name));
  return name;
}

Eigen::Vector3d readAxis(const YamlNode& node) {
  const Eigen::Vector3d axis = node.vector3();
  if (axis.norm() < 1e-9) node.fail("found a zero vector, expected an axis");
  // What is of unit length but for rounding stays as it is: a written model reads back bit by bit.
  return std::abs(axis.norm() - 1.0) < 1e-12 ? axis : axis.normalized();
}

Eigen::Quaterniond readOrientation(const YamlNode& node, const std::string& stem) {
  const auto given = node.find(stem + "orientation");
  if (node.hasQuantity(stem + "rpy", "rad")) {
    if (given) given->fail(fmt::format("found {0}rpy beside {0}orientation, expected one of them", stem));
    return fromRollPitchYaw(node.vectorQuantity(stem + "rpy", "rad"));
  }
  if (!given) return Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond q = given->unitQuaternion();
  return std::abs(q.norm() - 1.0) < 1e-12 ? q : q.normalized();
}

std::string_view jointUnit(const Joint& joint, std::string_view unit) {
  if (!joint.slides()) return unit;
  if (unit == "rad") return "m";
  if (unit == "Nm") return "N";
  if (unit == "Nms") return "Ns_m";
  return "N_m";  // Nm_rad
}

/// Between two joints in one place stands a body without mass; what hangs on it has some.
static bool carriesMass(const ArmModel& model, const Body& body) {
  const int index = static_cast<int>(&body - model.bodies.data());
  return std::any_of(model.joints.begin(), model.joints.end(), [&](const Joint& joint) {
    const Body& child = model.bodies[joint.child];
    return joint.parent == index && (!child.parts.empty() || carriesMass(model, child));
  });
}

Places readBodiesAndJoints(const YamlNode& root, ArmModel& model, bool second_version, const MeshReader& mesh) {
  std::set<std::string> names;
  const std::vector<YamlNode> body_nodes = root.at("bodies").items();
  for (const YamlNode& body : body_nodes) model.bodies.push_back(readBodyEntry(body, names, second_version, mesh));
  const YamlNode joints = root.at("joints");
  std::set<std::string> joint_names;
  std::vector<Entry> entries;
  for (const YamlNode& joint : joints.items()) {
    entries.push_back(readJoint(joint, model.bodies, joint_names, second_version));
  }
  if (entries.empty()) joints.fail("found no joint, expected at least one");
  entries = sortedTree(entries, model.bodies, joints);
  Places places = placesOf(model.bodies);
  if (std::any_of(entries.begin(), entries.end(), [](const Entry& entry) { return entry.fixed; })) {
    weldFixed(entries, model.bodies, places);
  }
  if (entries.empty()) joints.fail("found fixed joints only, expected one that moves");
  for (const Entry& entry : entries) model.joints.push_back(entry.joint);
  couple(entries, model.joints);
  for (const YamlNode& node : body_nodes) {
    const Body& body = model.bodies[places.at(node.at("name").text()).body];
    if (body.fixed || !body.parts.empty() || (second_version && carriesMass(model, body))) continue;
    node.fail("a body that moves needs 'parts' (mass > 0), or a body with parts that hangs on it");
  }
  return places;
}

}  // namespace simgap::arm_yaml
