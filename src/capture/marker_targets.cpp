#include "simgap/capture/marker_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr std::size_t kMostMarkers = 16;
constexpr double kSmallestDistance = 1e-3;  // [m] between two markers

/// Largest distance of a marker from the line through the two markers farthest apart. [m]
double widthOf(const std::vector<Eigen::Vector3d>& markers) {
  double longest = -1.0;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const auto& a : markers) {
    for (const auto& b : markers) {
      if ((b - a).norm() <= longest) continue;
      longest = (b - a).norm();
      from = a;
      direction = (b - a).normalized();
    }
  }
  double width = 0.0;
  for (const auto& m : markers) width = std::max(width, direction.cross(m - from).norm());
  return width;
}

void checkMarkers(const MarkerTarget& target, const YamlNode& node) {
  const std::size_t n = target.markers.size();
  if (n < 3 || n > kMostMarkers) node.fail(fmt::format("found {} markers, expected 3 to {}", n, kMostMarkers));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = (target.markers[i] - target.markers[j]).norm();
      if (distance < kSmallestDistance) {
        node.fail(fmt::format("markers {} and {} are {:.2g} mm apart, expected at least 1 mm", j, i, 1e3 * distance));
      }
    }
  }
  if (widthOf(target.markers) < kSmallestDistance) node.fail("all markers lie on one line: they fix no rotation");
}

int targetByName(const YamlNode& node, const TargetSet& targets) {
  const std::string name = node.text();
  const int index = targets.indexOf(name);
  if (index < 0) node.fail(fmt::format("found the target '{}', which the target file does not have", name));
  return index;
}

ScaleBar readScaleBar(const YamlNode& node, const TargetSet& targets) {
  ScaleBar bar;
  for (std::size_t end = 0; end < 2; ++end) {
    const YamlNode entry = node.at(end == 0 ? "from" : "to");
    const auto items = entry.items();
    if (items.size() != 2) entry.fail("expected [target, marker number]");
    bar.target[end] = targetByName(items[0], targets);
    const auto& markers = targets.targets[bar.target[end]].markers;
    bar.marker[end] = static_cast<int>(items[1].integer(0, static_cast<long>(markers.size()) - 1));
  }
  bar.length = node.quantity("length", "m", kPositive);
  return bar;
}

Eigen::Vector3d directionOf(const YamlNode& node) {
  const Eigen::Vector3d direction = node.vector3();
  if (direction.norm() < 1e-6) node.fail("expected a direction, found no length");
  return direction.normalized();
}

CaptureJoint readJoint(const YamlNode& node, const TargetSet& targets) {
  CaptureJoint joint;
  joint.name = node.at("name").text();
  joint.type = readJointType(node.at("type"));
  joint.parent = targetByName(node.at("parent"), targets);
  joint.child = targetByName(node.at("child"), targets);
  if (kindOf(joint.type).has_axis) {
    joint.axis = directionOf(node.at("axis"));
  }
  if (kindOf(joint.type).slides) joint.zero = node.findQuantity("zero", "m").value_or(0.0);
  if (const auto along = node.find("along")) joint.along = directionOf(*along);
  return joint;
}

int targetOfBody(const TargetSet& targets, const std::string& body) {
  for (std::size_t i = 0; i < targets.targets.size(); ++i) {
    if (targets.targets[i].body == body) return static_cast<int>(i);
  }
  return -1;
}

std::vector<CaptureJoint> paperJoints(const TargetSet& targets) {
  const int torso = targetOfBody(targets, "torso");
  const int humerus = targetOfBody(targets, "humerus");
  const int forearm = targetOfBody(targets, "forearm");
  std::vector<CaptureJoint> joints;
  if (torso >= 0 && humerus >= 0) {
    joints.push_back({"shoulder", JointType::kSpherical, torso, humerus, Eigen::Vector3d::UnitX()});
  }
  if (humerus >= 0 && forearm >= 0) {
    joints.push_back(
        {"elbow", JointType::kRevolute, humerus, forearm, Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()});
  }
  return joints;
}

}  // namespace

int TargetSet::indexOf(const std::string& target) const {
  const auto found = std::find_if(targets.begin(), targets.end(), [&](const auto& t) { return t.name == target; });
  return found == targets.end() ? -1 : static_cast<int>(found - targets.begin());
}

TargetSet readTargets(const YamlNode& root) {
  root.at("format").oneOf({"simgap/targets/1"});
  TargetSet set;
  set.marker_radius = root.quantity("marker_radius", "m", kPositive);
  const YamlNode list = root.at("targets");
  for (const YamlNode& node : list.items()) {
    MarkerTarget target;
    target.name = node.at("name").text();
    target.body = node.at("body").text();
    if (set.indexOf(target.name) >= 0) node.at("name").fail(fmt::format("the target '{}' stands twice", target.name));
    const YamlNode markers = node.at("markers_m");
    for (const YamlNode& marker : markers.items()) target.markers.push_back(marker.vector3());
    checkMarkers(target, markers);
    set.targets.push_back(std::move(target));
  }
  if (set.targets.empty()) list.fail("found no target, expected at least one");
  root.expectAllRead();
  return set;
}

std::string writeTargets(const TargetSet& set, const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + comment + "\n";
  text += fmt::format("format: simgap/targets/1\nmarker_radius_m: {}\ntargets:\n", set.marker_radius);
  for (const MarkerTarget& target : set.targets) {
    text += fmt::format("  - name: {}\n    body: {}\n    markers_m:\n", yamlText(target.name), yamlText(target.body));
    for (const auto& m : target.markers) text += fmt::format("      - [{}, {}, {}]\n", m.x(), m.y(), m.z());
  }
  return text;
}

std::array<std::string, 2> rigFiles(const YamlNode& root) {
  root.at("format").oneOf({"simgap/rig/1"});
  return {root.at("stereo").text(), root.at("targets").text()};
}

Rig readRig(const YamlNode& root, const TargetSet& targets) {
  Rig rig;
  const auto files = rigFiles(root);
  rig.stereo_file = files[0];
  rig.targets_file = files[1];
  if (const auto bar = root.find("scale_bar")) rig.scale_bar = readScaleBar(*bar, targets);
  if (const auto joints = root.find("joints")) {
    std::set<std::string> names;
    for (const YamlNode& node : joints->items()) {
      rig.joints.push_back(readJoint(node, targets));
      if (!names.insert(rig.joints.back().name).second) node.fail("a joint of this name stands above");
    }
  } else {
    rig.joints = paperJoints(targets);
  }
  root.expectAllRead();
  return rig;
}

std::string writeRig(const Rig& rig, const TargetSet& targets) {
  const auto name = [&](int target) { return yamlText(targets.targets[target].name); };
  const auto numbers = [](const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); };
  std::string text = fmt::format("format: simgap/rig/1\nstereo: {}\ntargets: {}\n", yamlText(rig.stereo_file),
                                 yamlText(rig.targets_file));
  if (rig.scale_bar) {
    const ScaleBar& bar = *rig.scale_bar;
    text += fmt::format("scale_bar: {{from: [{}, {}], to: [{}, {}], length_m: {}}}\n", name(bar.target[0]),
                        bar.marker[0], name(bar.target[1]), bar.marker[1], bar.length);
  }
  text += "joints:\n";
  for (const CaptureJoint& joint : rig.joints) {
    const JointKind& kind = kindOf(joint.type);
    text += fmt::format("  - {{name: {}, type: {}, parent: {}, child: {}", yamlText(joint.name), kind.name,
                        name(joint.parent), name(joint.child));
    if (kind.has_axis) text += ", axis: " + numbers(joint.axis);
    if (joint.along) text += ", along: " + numbers(*joint.along);
    if (kindOf(joint.type).slides) text += fmt::format(", zero_m: {}", joint.zero);
    text += "}\n";
  }
  return text;
}

}  // namespace simgap
