#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>

#include "simgap/core/joint_kind.h"
#include "simgap/fit/dynamics/excitation.h"

namespace simgap {
namespace {

constexpr double kOwnTurn = 3.0;   // [rad] to both sides of 0, of a hinge without limits
constexpr double kOwnNoise = 1.0;  // only ratios between joints matter

int bodyNamed(const YamlNode& node, const ArmModel& arm) {
  const std::string name = node.text();
  const auto found = std::ranges::find(arm.bodies, name, &Body::name);
  if (found == arm.bodies.end()) node.fail(fmt::format("found '{}', expected a body of {}", name, arm.name));
  return static_cast<int>(found - arm.bodies.begin());
}

/// Keys of one joint stand before those of `all_joints`.
class JointKeys {
 public:
  JointKeys(std::optional<YamlNode> own, std::optional<YamlNode> all) : own_(std::move(own)), all_(std::move(all)) {}
  std::optional<double> find(std::string_view stem, const std::string& unit, const Range& range) const {
    for (const std::optional<YamlNode>& node : {own_, all_}) {
      if (!node || !node->hasQuantity(stem, unit)) continue;
      return node->quantity(stem, unit, range);
    }
    return std::nullopt;
  }

 private:
  std::optional<YamlNode> own_, all_;
};

JointExcitationLimits limitsOf(const YamlNode& root, const Joint& joint) {
  const std::optional<YamlNode> joints = root.find("joints");
  const JointKeys keys(joints ? joints->find(joint.name) : std::nullopt, root.find("all_joints"));
  const std::string unit(kindOf(joint.type).unit), effort = joint.slides() ? "N" : "Nm";
  const auto needed = [&](std::string_view stem, const std::string& of) {
    const std::optional<double> value = keys.find(stem, of, kPositive);
    if (!value)
      root.fail(fmt::format("joint {}: found no {}_{}, expected it under joints or all_joints", joint.name, stem, of));
    return *value;
  };
  JointExcitationLimits limits{};
  const bool bounded = joint.lower_limit > -Joint::kUnlimited && joint.upper_limit < Joint::kUnlimited;
  const double lower = bounded ? joint.lower_limit : -kOwnTurn, upper = bounded ? joint.upper_limit : kOwnTurn;
  const std::optional<double> own_lower = keys.find("lower", unit, kAnyNumber);
  const std::optional<double> own_upper = keys.find("upper", unit, kAnyNumber);
  if (joint.slides() && !bounded && (!own_lower || !own_upper)) {
    root.fail(fmt::format("joint {} slides without limits, expected lower_m and upper_m", joint.name));
  }
  limits.lower = own_lower ? std::max(*own_lower, joint.lower_limit) : lower;
  limits.upper = own_upper ? std::min(*own_upper, joint.upper_limit) : upper;
  if (!(limits.lower < limits.upper)) {
    root.fail(fmt::format("joint {}: found limits {:g} and {:g} {}, expected the lower one first", joint.name,
                          limits.lower, limits.upper, unit));
  }
  limits.velocity = needed("velocity", unit + "_s");
  limits.acceleration = needed("acceleration", unit + "_s2");
  limits.effort = keys.find(joint.slides() ? "force" : "torque", effort, kPositive).value_or(kInfinity);
  limits.noise = keys.find("noise", effort, kPositive).value_or(kOwnNoise);
  return limits;
}

/// Keys for all joints may be those of hinges and of slides, though a robot has only one kind of them.
void readForBothKinds(const YamlNode& all) {
  for (const auto& [unit, stem, effort] : {std::tuple{"rad", "torque", "Nm"}, std::tuple{"m", "force", "N"}}) {
    all.findQuantity("lower", unit);
    all.findQuantity("upper", unit);
    all.findQuantity("velocity", fmt::format("{}_s", unit), kPositive);
    all.findQuantity("acceleration", fmt::format("{}_s2", unit), kPositive);
    all.findQuantity(stem, effort, kPositive);
    all.findQuantity("noise", effort, kPositive);
  }
}

DistanceLimit distanceOf(const YamlNode& node, const ArmModel& arm) {
  DistanceLimit limit;
  const auto pointOf = [](const YamlNode& of) {
    return of.hasQuantity("point", "m") ? of.vectorQuantity("point", "m") : Eigen::Vector3d::Zero();
  };
  limit.body = bodyNamed(node.at("body"), arm);
  limit.point = pointOf(node);
  limit.least = node.quantity("at_least", "m", kNonNegative);
  const std::string& name = arm.bodies[limit.body].name;
  if (const std::optional<YamlNode> other = node.find("from")) {
    limit.other = bodyNamed(other->at("body"), arm);
    limit.other_point = pointOf(*other);
    limit.name = fmt::format("{} from {}", name, arm.bodies[limit.other].name);
    return limit;
  }
  const YamlNode plane = node.at("plane");
  limit.normal = plane.at("normal").vector3();
  if (limit.normal.norm() < 1e-9) plane.fail("normal: found no direction, expected a vector that is not 0");
  limit.normal.normalize();
  limit.plane = plane.findQuantity("at", "m").value_or(0.0);
  limit.name = name + " over a plane";
  return limit;
}

}  // namespace

ExcitationLimits ExcitationLimits::read(const YamlNode& root, const ArmModel& arm) {
  root.at("format").oneOf({"simgap/excitation-limits/1"});
  const auto count = [&](const char* key, long least, long most, int other) {
    const std::optional<YamlNode> node = root.find(key);
    return node ? static_cast<int>(node->integer(least, most)) : other;
  };
  ExcitationLimits limits;
  limits.duration = root.findQuantity("duration", "s", {0.1, 1000.0, false, "0.1 to 1000 s"}).value_or(limits.duration);
  limits.rate = root.findQuantity("rate", "Hz", {1.0, 10000.0, false, "1 to 10000 Hz"}).value_or(limits.rate);
  limits.periods = count("periods", 1, 1000, limits.periods);
  limits.harmonics = count("harmonics", 2, 20, limits.harmonics);
  if (limits.rate * limits.duration < 10.0 * limits.harmonics) {
    root.fail(fmt::format("found {:g} rows in a period of {} harmonics, expected 10 or more for each",
                          limits.rate * limits.duration, limits.harmonics));
  }
  if (limits.rate * limits.duration * limits.periods > 1e6) root.fail("expected at most 1000000 rows");
  if (const std::optional<YamlNode> payload = root.find("payload")) {
    limits.payload = arm.bodies[bodyNamed(payload->at("body"), arm)].name;
  }
  if (const std::optional<YamlNode> all = root.find("all_joints")) readForBothKinds(*all);
  const InverseDynamics dynamics(arm);
  std::vector<std::string> names;
  for (const int joint : dynamics.joints()) {
    names.push_back(arm.joints[joint].name);
    limits.joints.push_back(limitsOf(root, arm.joints[joint]));
  }
  if (const std::optional<YamlNode> joints = root.find("joints")) {
    for (const std::string& name : joints->keys()) {
      if (std::ranges::find(names, name) == names.end()) {
        joints->fail(fmt::format("found '{}', expected joints of {}: {}", name, arm.name, fmt::join(names, ", ")));
      }
    }
  }
  if (const std::optional<YamlNode> distances = root.find("distances")) {
    for (const YamlNode& node : distances->items()) limits.distances.push_back(distanceOf(node, arm));
  }
  root.expectAllRead();
  return limits;
}

}  // namespace simgap
