#include "link_tree.h"

#include <fmt/format.h>

#include <algorithm>

#include "arm_exchange.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kMostLinks = 1000;

}  // namespace

void LinkTree::fail(const std::string& sentence) const {
  throw DataError(fmt::format("{}: {}", file_.filename().string(), sentence));
}

void LinkTree::addLink(const XmlElement& element, const std::string& name, const MassProperties& mass) {
  if (links_.size() >= kMostLinks) xml_.fail(element, fmt::format("found more than {} links", kMostLinks));
  if (!links_.emplace(name, mass).second) xml_.fail(element, fmt::format("the name '{}' is taken", abridged(name)));
  order_.push_back(name);
  if (element.FirstChildElement("inertial")) stated_.insert(name);
  if (element.FirstChildElement("visual") || element.FirstChildElement("collision")) drawn_.insert(name);
  place_of_[name] = xml_.place(element);
  for (const auto* e = element.FirstChildElement("collision"); e; e = e->NextSiblingElement("collision")) {
    xml_.remark(*e, "collision", "left out: bodies pass through each other");
  }
}

void LinkTree::addJoint(LinkJoint joint, const std::string& name) {
  joint.said = name;
  joints_.push_back(std::move(joint));
}

void LinkTree::nameAll() {
  std::vector<NameWish> links, joints;
  for (const std::string& link : order_) links.push_back({&body_name_[link], "link", link, place_of_.at(link), "link"});
  for (LinkJoint& joint : joints_) joints.push_back({&joint.joint.name, "joint", joint.said, joint.place, "joint"});
  std::set<std::string> taken_links, taken_joints;
  giveNames(links, taken_links, xml_);
  giveNames(joints, taken_joints, xml_);
}

ArmModel LinkTree::build(ArmModel arm) {
  arm_ = std::move(arm);
  const std::string base = baseLink();
  nameAll();
  arm_.bodies.push_back({.name = body_name_.at(base), .fixed = true, .parts = {}, .surfaces = {}});
  const auto where = where_.find(base);
  places_[base] = {0, where == where_.end() ? Eigen::Isometry3d::Identity() : where->second};
  attachChildren(base);
  refuseCircles();
  nameStillBase(base);
  nameMassless();
  if (arm_.joints.empty()) fail("found no joint that moves, expected at least one");
  for (const LinkJoint& joint : joints_) follow(joint);
  return std::move(arm_);
}

/// A base that weighs something and is not said to be the world may be one that floats.
void LinkTree::nameStillBase(const std::string& base) {
  if (base == "world") return;
  const bool heavy = std::ranges::any_of(
      places_, [&](const auto& link) { return link.second.first == 0 && links_.at(link.first).mass > 0.0; });
  if (heavy)
    xml_.add("a base without a joint to the world", "stands still where it is drawn", true, place_of_.at(base));
}

/// A link that only stands between two joints has no shape; one with a shape that weighs nothing was forgotten.
void LinkTree::nameMassless() {
  for (const std::string& link : order_) {
    const auto place = places_.find(link);
    if (place == places_.end() || arm_.bodies[place->second.first].fixed) continue;
    const std::string what =
        fmt::format("link '{}' without {}", abridged(link), stated_.contains(link) ? "mass" : "inertial");
    if (!unstated_.empty() && !stated_.contains(link)) {
      xml_.add(what, fmt::format("weighs nothing here; {}", unstated_), true, place_of_.at(link));
    } else if (massProperties(arm_.bodies[place->second.first]).mass <= 0.0) {
      const bool drawn = drawn_.contains(link);
      xml_.add(what,
               drawn ? "moves and weighs nothing: no mass is worked out of its shape" : "moves and weighs nothing",
               drawn, place_of_.at(link));
    }
  }
}

/// Every link has one parent at most, so what does not hang on the base hangs on itself.
void LinkTree::refuseCircles() const {
  for (const std::string& link : order_) {
    if (places_.contains(link)) continue;
    throw DataError(fmt::format("{}: link '{}' hangs on itself: its joints run in a circle, expected a tree",
                                place_of_.at(link), abridged(link)));
  }
}

/// The one link that no joint moves.
std::string LinkTree::baseLink() const {
  std::map<std::string, int> parents;
  for (const LinkJoint& joint : joints_) {
    for (const std::string& link : {joint.parent, joint.child}) {
      if (!links_.contains(link)) {
        throw DataError(fmt::format("{}: found '{}', expected the name of a link", joint.place, abridged(link)));
      }
    }
    if (++parents[joint.child] > 1) {
      throw DataError(
          fmt::format("{}: link '{}' is the child of two joints, expected a tree", joint.place, abridged(joint.child)));
    }
  }
  std::vector<std::string> roots;
  for (const std::string& link : order_) {
    if (!parents.contains(link)) roots.push_back(link);
  }
  if (order_.empty()) fail("found no link, expected at least two");
  if (roots.size() != 1) {
    fail(fmt::format("found {} links that hang on no other{}, expected one", roots.size(),
                     roots.empty() ? " (the joints run in a circle)" : ""));
  }
  return roots[0];
}

void LinkTree::attachChildren(const std::string& link) {
  for (LinkJoint& joint : joints_) {
    if (joint.parent != link) continue;
    const auto [body, frame] = places_.at(link);
    const Eigen::Isometry3d in_body = frame * joint.in_parent;
    const MassProperties& mass = links_.at(joint.child);
    if (joint.fixed) {
      const Eigen::Isometry3d there = in_body * joint.in_child.inverse();
      places_[joint.child] = {body, there};
      Body& carrier = arm_.bodies[body];
      xml_.add(fmt::format("link '{}'", abridged(joint.child)),
               fmt::format("fixed: a part of '{}'", abridged(carrier.name)), false, joint.place);
      if (!carrier.fixed && mass.mass > 0.0) {
        MassProperties moved{mass.mass, there * mass.centre_of_mass, {}};
        moved.inertia = there.linear() * mass.inertia * there.linear().transpose();
        carrier.parts.push_back(statedPart(freePartName(carrier, body_name_.at(joint.child)), moved));
        arm_places_["bodies " + carrier.parts.back().name] = place_of_.at(joint.child);
      }
    } else {
      joint.joint.parent = body;
      joint.joint.child = static_cast<int>(arm_.bodies.size());
      joint.joint.parent_position = in_body.translation();
      joint.joint.parent_orientation = tidyRotation(in_body.linear());
      joint.joint.child_position = joint.in_child.translation();
      joint.joint.child_orientation = tidyRotation(joint.in_child.linear());
      places_[joint.child] = {joint.joint.child, Eigen::Isometry3d::Identity()};
      Body& moved = arm_.bodies.emplace_back();
      moved.name = body_name_.at(joint.child);
      if (mass.mass > 0.0) moved.parts.push_back(statedPart(moved.name, mass));
      arm_.joints.push_back(joint.joint);
      arm_places_["bodies " + moved.name] = place_of_.at(joint.child);
      arm_places_["joints " + joint.joint.name] = joint.place;
    }
    attachChildren(joint.child);
  }
}

std::optional<std::pair<int, Eigen::Isometry3d>> LinkTree::placeOf(const std::string& link) const {
  const auto found = places_.find(link);
  return found == places_.end() ? std::nullopt : std::optional(found->second);
}

void LinkTree::follow(const LinkJoint& joint) {
  if (joint.leader.empty()) return;
  const auto index = [&](const std::string& name) {
    return static_cast<int>(std::ranges::find(arm_.joints, name, &Joint::name) - arm_.joints.begin());
  };
  const auto leader = std::ranges::find(joints_, joint.leader, &LinkJoint::said);
  if (leader == joints_.end() || leader->fixed) {
    throw DataError(fmt::format("{}: mimic: found '{}', expected the name of a joint that moves", joint.place,
                                abridged(joint.leader)));
  }
  tieJoints(arm_, index(joint.joint.name), index(leader->joint.name), joint.multiplier, joint.offset, joint.place);
}

}  // namespace simgap
