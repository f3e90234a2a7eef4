#include "simgap/model/arm/arm_effect.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/names.h"
#include "simgap/model/arm/arm_tree.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap {
namespace {

using Target = ArmEffect::Target;

std::string_view groupOf(Target target) {
  switch (target) {
    case Target::kMuscle:
    case Target::kMuscleOrAll:
      return "muscle";
    case Target::kLine:
      return "line";
    case Target::kTendon:
      return "tendon";
    case Target::kBody:
    case Target::kMovingBody:
      return "body";
    case Target::kJoint:
      return "joint";
    case Target::kNone:
      break;
  }
  return "";
}

int targetIndex(const ArmEffect& effect, const ArmModel& model, std::string_view target) {
  const std::string_view group = groupOf(effect.target);
  const int muscle = group == "muscle" || group == "line" ? indexOf(model.muscles, target) : -1;
  if (muscle >= 0) return muscle;
  if (group == "line" || group == "tendon") {
    const int tendon = indexOf(model.tendons, target);
    return tendon < 0 ? -1 : static_cast<int>(model.muscles.size()) + tendon;
  }
  if (group == "body") return indexOf(model.bodies, target);
  if (group == "joint") return indexOf(model.joints, target);
  return -1;
}

}  // namespace

const ArmEffect* findArmEffect(std::string_view name) {
  for (const ArmEffect* effect : arm_effects::all()) {
    if (effect->name == name) return effect;
  }
  return nullptr;
}

std::vector<std::string> effectTargets(const ArmEffect& effect, const ArmModel& model) {
  std::vector<std::string> targets;
  const std::string_view group = groupOf(effect.target);
  if (group.empty() || effect.target == Target::kMuscleOrAll) targets.emplace_back();
  if (group == "muscle" || group == "line") {
    for (const Muscle& muscle : model.muscles) targets.push_back(muscle.name);
  }
  if (group == "tendon" || group == "line") {
    for (const PassiveTendon& tendon : model.tendons) targets.push_back(tendon.name);
  } else if (group == "joint") {
    for (const Joint& joint : model.joints) targets.push_back(joint.name);
  } else if (group == "body") {
    for (const Body& body : model.bodies) {
      if (effect.target == Target::kBody || !body.fixed) targets.push_back(body.name);
    }
  }
  return targets;
}

const TendonPath& lineOf(const ArmModel& model, int line) {
  const int muscles = static_cast<int>(model.muscles.size());
  if (line < muscles) return model.muscles[line];
  return model.tendons[line - muscles];
}

std::vector<int> jointsCrossed(const ArmModel& model, const TendonPath& line) {
  std::vector<int> up = jointsAbove(model, line.attachments[0].body);
  std::vector<int> down = jointsAbove(model, line.attachments[1].body);
  while (!up.empty() && !down.empty() && up.back() == down.back()) {
    up.pop_back();
    down.pop_back();
  }
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

bool wrapsAsSurface(const ArmModel& model, int line) {
  return line >= std::ssize(model.muscles) || !lineOf(model, line).straight() ||
         std::ranges::any_of(model.joints, &Joint::slides);
}

int freeStretchOver(const ArmModel& model, const TendonPath& line, int joint) {
  const auto below = [&](int body) {
    const std::vector<int> above = jointsAbove(model, body);
    return std::ranges::find(above, joint) != above.end();
  };
  const std::vector<PathStretch> stretches = partsOf(line).stretches;
  const auto found = std::ranges::find_if(stretches, [&](const PathStretch& stretch) {
    return stretch.over < 0 && below(stretch.ends[0].body) != below(stretch.ends[1].body);
  });
  return found == stretches.end() ? -1 : static_cast<int>(found - stretches.begin());
}

int restLengthOf(const PassiveTendon& tendon) {
  const auto& known = tendon.kind->parameters;
  const auto found = std::ranges::find(known, "rest_length", &TendonParameter::name);
  return found == known.end() ? -1 : static_cast<int>(found - known.begin());
}

std::vector<ArmExtension> resolveExtensions(const ArmModel& model) {
  std::vector<ArmExtension> resolved;
  resolved.reserve(model.extensions.size());
  for (const Extension& extension : model.extensions) {
    ArmExtension& entry = resolved.emplace_back();
    entry.effect = findArmEffect(extension.effect);
    entry.target = extension.target.empty() ? -1 : targetIndex(*entry.effect, model, extension.target);
    for (std::size_t i = 0; i < extension.parameters.size(); ++i) entry.p[i] = extension.parameters[i].value;
  }
  return resolved;
}

std::string checkExtension(Extension& extension, const ArmModel& model) {
  const ArmEffect* effect = findArmEffect(extension.effect);
  if (!effect) {
    std::vector<std::string_view> known;
    for (const ArmEffect* other : arm_effects::all()) known.push_back(other->name);
    return fmt::format("found '{}', expected one of {}", extension.effect, fmt::join(known, ", "));
  }
  const std::vector<std::string> targets = effectTargets(*effect, model);
  if (std::ranges::find(targets, extension.target) == targets.end()) {
    const std::string_view group = groupOf(effect->target);
    if (group.empty()) return fmt::format("found the target '{}', {} has none", extension.target, effect->name);
    return fmt::format("found the target '{}' of {}, expected the name of a {}", extension.target, effect->name,
                       group == "line" ? "muscle or tendon" : group);
  }
  std::vector<Estimate> ordered;
  EffectParameters p{};
  const ArmSizes arm = sizesOf(model);
  for (const ArmEffectParameter& wanted : effect->parameters) {
    const auto found = std::ranges::find(extension.parameters, wanted.name, &Estimate::name);
    if (found == extension.parameters.end()) {
      return fmt::format("found no parameter {} of {}, expected {{value, unit: \"{}\"}}", wanted.name, effect->name,
                         wanted.unit);
    }
    if (found->unit != wanted.unit) {
      return fmt::format("found {} of {} in '{}', expected the unit {}", wanted.name, effect->name, found->unit,
                         wanted.unit);
    }
    const Range range = rangeOn(wanted.range, wanted.size, arm);
    if (!(found->value >= range.lower && found->value <= range.upper)) {
      return fmt::format("found {} = {} of {}, expected {}", wanted.name, found->value, effect->name,
                         range.upper == wanted.range.upper
                             ? std::string(range.expected)
                             : fmt::format("a number in [{:.4g}, {:.4g}]", range.lower, range.upper));
    }
    p[ordered.size()] = found->value;
    ordered.push_back(*found);
  }
  for (const Estimate& given : extension.parameters) {
    if (std::ranges::find(effect->parameters, given.name, &ArmEffectParameter::name) == effect->parameters.end()) {
      return fmt::format("{} has no parameter '{}'", effect->name, given.name);
    }
  }
  extension.parameters = std::move(ordered);
  if (effect->supply && model.muscles.empty()) return fmt::format("{} needs a motor on a line", effect->name);
  if (!effect->expected) return "";
  const std::string expected = effect->expected(p, model, targetIndex(*effect, model, extension.target));
  return expected.empty() ? "" : fmt::format("{} of {}: expected {}", effect->name, extension.target, expected);
}

Range rangeOn(const Range& range, ArmSize size, const ArmSizes& arm) {
  const double wider = std::max(1.0, arm.of(size));
  return {wider * range.lower, wider * range.upper, range.lower_open, range.expected};
}

ArmEffectParameter onArm(const ArmEffectParameter& parameter, const ArmSizes& arm) {
  const double factor = arm.of(parameter.size);
  ArmEffectParameter on = parameter;
  on.range = rangeOn(parameter.range, parameter.size, arm);
  on.neutral *= factor;
  on.scale *= factor;
  return on;
}

EffectParameters startOn(const ArmEffect& effect, const EffectParameters& start, const ArmSizes& arm) {
  EffectParameters on = start;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) on[i] *= arm.of(effect.parameters[i].size);
  return on;
}

Extension makeExtension(const ArmEffect& effect, const std::string& target, const EffectParameters& p) {
  Extension extension{std::string(effect.name), target, {}};
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const ArmEffectParameter& parameter = effect.parameters[i];
    extension.parameters.push_back({std::string(parameter.name), std::string(parameter.unit), p[i], std::nan("")});
  }
  return extension;
}

namespace {

TendonPath& pathOf(ArmModel& model, int line) { return const_cast<TendonPath&>(lineOf(model, line)); }

/// A sphere about the centre of the joint on the way of a line.
void wrapLine(const EffectParameters& p, int line, ArmModel& model) {
  TendonPath& path = pathOf(model, line);
  const int obstacle = jointsCrossed(model, path)[static_cast<std::size_t>(std::lround(p[1])) - 1];
  const Joint& joint = model.joints[obstacle];
  const int stretch = freeStretchOver(model, path, obstacle);
  Body& body = model.bodies[joint.child];
  path.wrap = TendonPath::Wrap{stretch, joint.child, static_cast<int>(body.surfaces.size())};
  Surface sphere;
  sphere.name = "wrap";
  sphere.shape = Surface::Shape::kSphere;
  sphere.radius = p[0];
  sphere.position = joint.child_position;
  body.surfaces.push_back(sphere);
}

}  // namespace

void applyToModel(std::span<const ArmExtension> extensions, ArmModel& model) {
  for (const auto& [effect, target, p] : extensions) {
    if (effect->change) effect->change(p, target, model);
    if (effect->gravity) model.gravity = effect->gravity(p, model.gravity).gravity;
    if (effect->joint_shift) model.joints[target].parent_position += effect->joint_shift(p);
    if (effect->hinge_axis) {
      Eigen::Vector3d& axis = model.joints[target].axis;
      axis = effect->hinge_axis(p, axis).axis;
    }
    if (effect->path && wrapsAsSurface(model, target)) wrapLine(p, target, model);
    if (effect->rest_shift) {
      PassiveTendon& tendon = model.tendons[target - static_cast<int>(model.muscles.size())];
      tendon.p[restLengthOf(tendon)] += effect->rest_shift(p);
    }
    if (!effect->mass) continue;
    constexpr double kRadius = 0.005;  // [m]: small, for a simulation that asks for its inertia
    const PointMass mass = effect->mass(p);
    const Eigen::Vector3d pivot = jointCarrying(model, target)->child_position;
    const Eigen::Vector3d way = massProperties(model.bodies[target]).centre_of_mass - pivot;
    Part part;
    part.name = "payload";
    part.shape = Part::Shape::kSphere;
    part.radius = kRadius;
    part.mass = mass.mass;
    part.position = pivot + mass.distance * (way.norm() > 0.0 ? way.normalized() : -Eigen::Vector3d::UnitZ());
    model.bodies[target].parts.push_back(part);
  }
}

namespace {

bool isOfNumbers(const ArmEffect& effect) {
  return effect.change || effect.gravity || effect.joint_shift || effect.hinge_axis || effect.path ||
         effect.rest_shift || effect.mass;
}

/// What wrapLine() put on a line, as a station like any other.
void makeStation(TendonPath& path, ArmModel& model, const std::string& line) {
  const auto [stretch, body, surface] = *path.wrap;
  const int end = partsOf(path).stretches[static_cast<std::size_t>(stretch)].station[1];
  path.wrap.reset();
  model.bodies[body].surfaces[static_cast<std::size_t>(surface)].name = "wrap of " + line;
  Station over;
  over.kind = Station::Kind::kSurface;
  over.at.body = body;
  over.surface = surface;
  path.between.insert(path.between.begin() + end - 1, over);
}

}  // namespace

std::vector<Extension> workExtensionsIn(ArmModel& model) {
  const std::vector<ArmExtension> resolved = resolveExtensions(model);
  std::vector<Extension> worked_in, left;
  for (std::size_t i = 0; i < resolved.size(); ++i) {
    const auto& [effect, target, p] = resolved[i];
    (isOfNumbers(*effect) ? worked_in : left).push_back(model.extensions[i]);
    if (!isOfNumbers(*effect)) continue;
    const bool as_surface = effect->path && wrapsAsSurface(model, target);
    applyToModel({&resolved[i], 1}, model);
    if (!effect->path) continue;
    if (!as_surface) wrapLine(p, target, model);
    TendonPath& path = pathOf(model, target);
    makeStation(path, model, model.extensions[i].target);
  }
  model.extensions = std::move(left);
  return worked_in;
}

JointPosition markedPosition(const Joint& joint, const JointPosition& position, const Eigen::Vector3d& parent_turn,
                             const Eigen::Vector3d& child_turn) {
  JointPosition marked = position;
  if (joint.slides()) return marked;
  if (!joint.hasAxis()) {
    marked.rotation = (expSo3(-parent_turn) * position.rotation * expSo3(child_turn)).normalized();
  } else {
    const Eigen::Quaterniond q(Eigen::AngleAxisd(position.angle, joint.axis));
    const Eigen::Quaterniond seen = expSo3(-parent_turn) * q * expSo3(child_turn);
    const double twist = 2.0 * std::atan2(seen.vec().dot(joint.axis), seen.w());
    marked.angle = position.angle + std::remainder(twist - position.angle, 4.0 * std::acos(0.0));
  }
  return marked;
}

}  // namespace simgap
