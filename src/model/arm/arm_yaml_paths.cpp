// Ways of lines in an arm file, and the lines without a motor.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "arm_yaml_parts.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap::arm_yaml {
namespace {

using Kind = Station::Kind;

const Place& readPlace(const YamlNode& node, const Places& places) {
  const auto found = places.find(node.text());
  if (found == places.end()) node.fail(fmt::format("found '{}', expected the name of a body", node.text()));
  return found->second;
}

Attachment readPoint(const YamlNode& node, const Places& places) {
  const Place& place = readPlace(node.at("body"), places);
  const Eigen::Vector3d point = node.vectorQuantity("point", "m");
  return {place.body, place.pose.isApprox(Eigen::Isometry3d::Identity(), 0.0) ? point : place.pose * point};
}

double distanceFromMiddle(const Surface& surface, const Eigen::Vector3d& point) {
  Eigen::Vector3d way = point - surface.position;
  if (surface.shape == Surface::Shape::kCylinder) way -= surface.axis * surface.axis.dot(way);
  return way.norm();
}

/// The side point in the frame of the surface's body, with every joint at 0.
Eigen::Vector3d drawnSide(const Station& station, const ArmModel& model) {
  if (station.side_body < 0) return station.at.point;
  const std::vector<BodyInWorld> drawn = bodiesInWorld(model, std::vector<JointPosition>(model.joints.size()));
  const BodyInWorld& body = drawn[station.at.body];
  return body.rotation.transpose() * (drawn[station.side_body] * station.at.point - body.origin);
}

Station readSurfaceStation(const YamlNode& node, const ArmModel& model, const Places& places) {
  Station station;
  station.kind = Kind::kSurface;
  const Place& place = readPlace(node.at("body"), places);
  const std::string name = node.at("over").text();
  const auto found = std::ranges::find(place.surfaces, name);
  if (found == place.surfaces.end()) {
    node.at("over").fail(fmt::format("found '{}', expected the name of a surface of the body, one of [{}]", name,
                                     fmt::join(place.surfaces, ", ")));
  }
  station.at.body = place.body;
  station.surface = place.first_surface + static_cast<int>(found - place.surfaces.begin());
  station.sided = node.hasQuantity("side", "m");
  if (!station.sided) return station;
  if (const auto other = node.find("side_body")) {  // where it is against the surface depends on the pose
    const Place& side = readPlace(*other, places);
    station.side_body = side.body;
    station.at.point = side.pose * node.vectorQuantity("side", "m");
    if (side.body == place.body) station.side_body = -1;
  } else {
    station.at.point = place.pose * node.vectorQuantity("side", "m");
  }
  const Surface& surface = model.bodies[place.body].surfaces[station.surface];
  const double distance = distanceFromMiddle(surface, drawnSide(station, model));
  if (distance <= surface.radius) {
    node.fail(
        fmt::format("side_m: found a point {:.3g} mm inside of '{}', of radius {:.4g} m; expected one outside: lines "
                    "that run inside of a surface are not modelled",
                    (surface.radius - distance) / 1e-3, name, surface.radius));
  }
  return station;
}

int readJointWithAxis(const YamlNode& node, const ArmModel& model) {
  const std::string name = node.text();
  const auto found = std::ranges::find(model.joints, name, &Joint::name);
  if (found == model.joints.end()) node.fail(fmt::format("found '{}', expected the name of a joint", name));
  if (!found->hasAxis()) node.fail(fmt::format("'{}' is spherical, expected a joint with one axis", name));
  return static_cast<int>(found - model.joints.begin());
}

Station readStation(const YamlNode& node, const ArmModel& model, const Places& places) {
  Station station;
  if (node.isMap() && node.has("over")) return readSurfaceStation(node, model, places);
  if (node.isMap() && node.has("pulley")) {
    station.kind = Kind::kPulley;
    station.divisor = node.at("pulley").number(kPositive);
    return station;
  }
  if (node.isMap() && node.has("joint")) {
    station.kind = Kind::kJoint;
    station.joint = readJointWithAxis(node.at("joint"), model);
    station.radius = model.joints[station.joint].slides() ? node.at("ratio").number() : node.quantity("radius", "m");
    if (station.radius == 0.0) node.fail("found a wheel of radius 0, expected another number");
    return station;
  }
  station.at = readPoint(node, places);
  return station;
}

/// Points stand at both ends of every branch and on both sides of every surface; wheels may stand anywhere.
void checkOrder(const std::vector<Station>& stations, const std::vector<YamlNode>& nodes) {
  const Station* before = nullptr;
  const auto describe = [](const Station* station) {
    return station == nullptr ? "the end" : station->kind == Kind::kSurface ? "a surface" : "a pulley";
  };
  for (std::size_t k = 0; k <= stations.size(); ++k) {
    const Station* now = k < stations.size() ? &stations[k] : nullptr;
    if (now && now->kind == Kind::kJoint) continue;
    const bool point = now && now->kind == Kind::kPoint;
    const bool point_before = before && before->kind == Kind::kPoint;
    if (!point && !point_before) {
      nodes[std::min(k, stations.size() - 1)].fail(
          fmt::format("found {} next to {}, expected a point {{body, point_m}} between them", describe(now),
                      before ? describe(before) : "the beginning"));
    }
    before = now;
  }
}

/// What no pose of the arm can mend: points inside of the surface next to them, two points in one place.
void checkPoints(const std::vector<Station>& stations, const std::vector<YamlNode>& nodes, const ArmModel& model) {
  for (std::size_t k = 0; k + 1 < stations.size(); ++k) {
    const Station &now = stations[k], &next = stations[k + 1];
    if (now.kind == Kind::kPoint && next.kind == Kind::kPoint && now.at == next.at) {
      nodes[k + 1].fail("found the same point as the one before it, expected another: a line needs a length");
    }
    const bool leaves = now.kind == Kind::kSurface;
    if (!leaves && next.kind != Kind::kSurface) continue;
    const Station &over = leaves ? now : next, &point = leaves ? next : now;
    const Surface& surface = model.bodies[over.at.body].surfaces[over.surface];
    if (point.kind != Kind::kPoint || point.at.body != over.at.body) continue;
    const double distance = distanceFromMiddle(surface, point.at.point);
    if (distance > surface.radius) continue;
    nodes[leaves ? k + 1 : k].fail(
        fmt::format("found a point {:.3g} mm inside of '{}', of radius {:.4g} m, expected one outside",
                    (surface.radius - distance) / 1e-3, surface.name, surface.radius));
  }
}

/// A line over joints alone begins and ends at one point that stands still.
TendonPath pathOverJoints(const ArmModel& model, std::vector<Station> wheels) {
  TendonPath path;
  const auto base = std::ranges::find(model.bodies, true, &Body::fixed);
  path.attachments.fill(Attachment{static_cast<int>(base - model.bodies.begin())});
  path.between = std::move(wheels);
  return path;
}

TendonPath readLongPath(const YamlNode& list, const std::vector<YamlNode>& nodes, const ArmModel& model,
                        const Places& places) {
  std::vector<Station> stations;
  stations.reserve(nodes.size());
  for (const YamlNode& node : nodes) stations.push_back(readStation(node, model, places));
  if (std::ranges::all_of(stations, [](const Station& s) { return s.kind == Kind::kJoint; })) {
    if (stations.empty()) list.fail("found no attachment, expected at least two points, or joints");
    return pathOverJoints(model, stations);
  }
  if (stations.front().kind != Kind::kPoint || stations.back().kind != Kind::kPoint || stations.size() < 2) {
    list.fail(
        fmt::format("found {} attachments, expected at least 2, the first and the last one a point {{body, "
                    "point_m}}",
                    stations.size()));
  }
  checkOrder(stations, nodes);
  checkPoints(stations, nodes, model);
  TendonPath path;
  path.attachments = {stations.front().at, stations.back().at};
  path.between.assign(stations.begin() + 1, stations.end() - 1);
  if (!jointsChange(path)) list.fail("all of the line is on one body, expected at least two bodies");
  return path;
}

/// What acts about a joint: a wheel of radius 1 m, on which the length is the angle, and the force a torque.
TendonPath pathAtJoint(const YamlNode& node, const ArmModel& model) {
  Station wheel;
  wheel.kind = Kind::kJoint;
  wheel.joint = readJointWithAxis(node, model);
  if (model.joints[wheel.joint].slides()) {
    node.fail(fmt::format("'{}' slides, expected a joint that turns", model.joints[wheel.joint].name));
  }
  wheel.radius = 1.0;
  return pathOverJoints(model, {wheel});
}

/// Whether a line is a point wherever its joints are, as between two bodies in the middle of the joint that both share.
bool hasNoLength(const ArmModel& model, const TendonPath& path) {
  return std::ranges::all_of(std::array{0.0, 0.1}, [&](double moved) {
    std::vector<JointPosition> joints = startPosition(model);
    for (std::size_t j = 0; j < joints.size(); ++j) {
      joints[j] = kindOf(model.joints[j].type).moved(joints[j], Eigen::Vector3d::Constant(moved));
    }
    return tendonLength(model, path, bodiesInWorld(model, joints), joints) < 2.0 * kShortestLine;
  });
}

TendonPath readWay(const YamlNode& list, const ArmModel& model, const Places& places, bool second_version) {
  const std::vector<YamlNode> nodes = list.items();
  const bool plain = std::ranges::all_of(nodes, [](const YamlNode& node) {
    return !node.isMap() || !(node.has("over") || node.has("pulley") || node.has("joint"));
  });
  if (second_version && !(plain && nodes.size() == 2)) return readLongPath(list, nodes, model, places);
  if (nodes.size() != 2) {
    list.fail(fmt::format("found {} attachments, expected 2{}", nodes.size(),
                          nodes.size() > 2 ? " ('format: simgap/arm/2' takes any number)" : ""));
  }
  TendonPath path;
  for (std::size_t i = 0; i < 2; ++i) path.attachments[i] = readPoint(nodes[i], places);
  if (path.attachments[0].body == path.attachments[1].body) {
    list.fail("both ends are on the same body, expected two bodies");
  }
  return path;
}

}  // namespace

TendonPath readPath(const YamlNode& list, const ArmModel& model, const Places& places, bool second_version) {
  TendonPath path = readWay(list, model, places, second_version);
  if (!path.jointsOnly() && hasNoLength(model, path)) {
    list.fail("found a line without length at any position of the joints, expected ends apart from each other");
  }
  return path;
}

PassiveTendon readTendon(const YamlNode& node, const ArmModel& model, const Places& places,
                         std::set<std::string>& names) {
  PassiveTendon tendon;
  tendon.name = readName(node, names);
  std::vector<std::string> known;
  for (const TendonKind* kind : tendon_kinds::all()) known.emplace_back(kind->name);
  const std::string name = node.at("kind").oneOf(known);
  tendon.kind = *std::ranges::find(tendon_kinds::all(), name, &TendonKind::name);
  static_cast<TendonPath&>(tendon) = tendon.kind->at_joint ? pathAtJoint(node.at("joint"), model)
                                                           : readPath(node.at("attachments"), model, places, true);
  for (std::size_t i = 0; i < tendon.kind->parameters.size(); ++i) {
    const TendonParameter& parameter = tendon.kind->parameters[i];
    if (parameter.otherwise) {
      tendon.p[i] = node.findQuantity(parameter.name, parameter.unit, parameter.range).value_or(*parameter.otherwise);
    } else {
      tendon.p[i] = parameter.unit == "1" ? node.at(parameter.key).number(parameter.range)
                                          : node.quantity(parameter.name, parameter.unit, parameter.range);
    }
  }
  return tendon;
}

}  // namespace simgap::arm_yaml
