#include "simgap/model/arm/parameter_space.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

/// Names the numbers of one item (a muscle, a joint, a body) on behalf of visitParameters.
template <class Visit>
class ItemVisitor {
 public:
  ItemVisitor(std::string_view group, std::string_view item, const Visit& visit)
      : group_(group), item_(item), visit_(visit) {}
  void operator()(std::string_view member, std::string_view unit, const Range& range, double& value,
                  ArmSize size = ArmSize::kNone) const {
    visit_(ParameterPath{group_, item_, member, -1}, ParameterKind{unit, range, size}, value);
  }
  void operator()(std::string_view member, std::string_view unit, Eigen::Vector3d& value) const {
    for (int i = 0; i < 3; ++i)
      visit_(ParameterPath{group_, item_, member, i}, ParameterKind{unit, kAnyNumber}, value[i]);
  }

 private:
  std::string_view group_, item_;
  const Visit& visit_;
};

/// Points and wheels by their places in the file's list.
template <class Visit>
void visitLongPath(TendonPath& path, const ItemVisitor<Visit>& visit) {
  const bool ends = !path.jointsOnly();
  if (ends) visit("attachments.0.point_m", "m", path.attachments[0].point);
  for (std::size_t k = 0; k < path.between.size(); ++k) {
    Station& station = path.between[k];
    const std::string stem = "attachments." + std::to_string(k + (ends ? 1 : 0));
    if (station.kind == Station::Kind::kPoint) visit(stem + ".point_m", "m", station.at.point);
    if (station.kind == Station::Kind::kJoint) visit(stem + ".radius_m", "m", kAnyNumber, station.radius);
  }
  const std::string last = "attachments." + std::to_string(path.between.size() + 1) + ".point_m";
  if (ends) visit(last, "m", path.attachments[1].point);
}

template <class Visit>
void visitMuscle(Muscle& muscle, const ItemVisitor<Visit>& visit) {
  if (muscle.straight()) {
    visit("attachments.0.point_m", "m", muscle.attachments[0].point);
    visit("attachments.1.point_m", "m", muscle.attachments[1].point);
  } else {
    visitLongPath(muscle, visit);
  }
  visit("kite_line_length_m", "m", kAnyNumber, muscle.kite_line_length);
  visit("shock_cord.rest_length_m", "m", kPositive, muscle.shock_cord.rest_length);
  visit("shock_cord.stiffness_N_m", "N_m", kPositive, muscle.shock_cord.stiffness);
  visit("shock_cord.damping_Ns_m", "Ns_m", kNonNegative, muscle.shock_cord.damping);
  visit("spindle_radius_m", "m", kPositive, muscle.spindle_radius);
  visit("motor.resistance_ohm", "ohm", kPositive, muscle.motor.resistance);
  visit("motor.inductance_H", "H", kPositive, muscle.motor.inductance);
  visit("motor.back_emf_constant_Vs", "Vs", kPositive, muscle.motor.back_emf_constant);
  visit("motor.torque_constant_Nm_A", "Nm_A", kPositive, muscle.motor.torque_constant);
  visit("motor.inertia_kg_m2", "kg_m2", kPositive, muscle.motor.inertia);
  visit("motor.viscous_friction_Nms", "Nms", kNonNegative, muscle.motor.viscous_friction);
  visit("motor.coulomb_friction_Nm", "Nm", kNonNegative, muscle.motor.coulomb_friction);
  visit("gearbox.efficiency", "1", kEfficiency, muscle.gearbox.efficiency);
  visit("gearbox.viscous_friction_Nms", "Nms", kNonNegative, muscle.gearbox.viscous_friction);
  visit("gearbox.coulomb_friction_Nm", "Nm", kNonNegative, muscle.gearbox.coulomb_friction);
}

template <class Visit>
void visitTendon(PassiveTendon& tendon, const ItemVisitor<Visit>& visit) {
  if (tendon.kind->at_joint) {  // no line
  } else if (tendon.straight()) {
    visit("attachments.0.point_m", "m", tendon.attachments[0].point);
    visit("attachments.1.point_m", "m", tendon.attachments[1].point);
  } else {
    visitLongPath(tendon, visit);
  }
  for (std::size_t i = 0; i < tendon.kind->parameters.size(); ++i) {
    const TendonParameter& parameter = tendon.kind->parameters[i];
    visit(parameter.key, parameter.unit, parameter.range, tendon.p[i]);
  }
}

/// The traversal itself, inlined with its visitor so that `apply` costs no calls and no strings.
template <class Visit>
void traverse(ArmModel& model, const Visit& visit) {
  ItemVisitor<Visit>("gravity_m_s2", "", visit)("", "m_s2", model.gravity);
  for (Body& body : model.bodies) {
    const ItemVisitor<Visit> item("bodies", body.name, visit);
    for (Part& part : body.parts) {
      const std::string mass = part.name + ".mass_kg";
      const std::string position = part.name + ".position_m";
      item(mass, "kg", kPositive, part.mass);
      item(position, "m", part.position);
    }
    for (Surface& surface : body.surfaces) {
      const std::string radius = surface.name + ".radius_m";
      const std::string position = surface.name + ".position_m";
      item(radius, "m", kPositive, surface.radius);
      item(position, "m", surface.position);
    }
  }
  for (Joint& joint : model.joints) {
    const ItemVisitor<Visit> item("joints", joint.name, visit);
    item("parent_position_m", "m", joint.parent_position);
    item("child_position_m", "m", joint.child_position);
    const bool slides = joint.slides();
    item(slides ? "coulomb_friction_N" : "coulomb_friction_Nm", slides ? "N" : "Nm", kNonNegative,
         joint.coulomb_friction);
    item(slides ? "viscous_friction_Ns_m" : "viscous_friction_Nms", slides ? "Ns_m" : "Nms", kNonNegative,
         joint.viscous_friction);
    if (joint.spring_stiffness <= 0.0) continue;
    item(slides ? "spring.stiffness_N_m" : "spring.stiffness_Nm_rad", slides ? "N_m" : "Nm_rad", kPositive,
         joint.spring_stiffness);
    if (joint.hasAxis())
      item(slides ? "spring.rest_m" : "spring.rest_rad", slides ? "m" : "rad", kAnyNumber, joint.spring_rest);
  }
  for (Muscle& muscle : model.muscles) visitMuscle(muscle, ItemVisitor<Visit>("muscles", muscle.name, visit));
  for (PassiveTendon& tendon : model.tendons) {
    const ItemVisitor<Visit> item("tendons", tendon.name, visit);
    visitTendon(tendon, item);
  }
  for (Extension& extension : model.extensions) {
    const std::string label = effectLabel(extension.effect, extension.target);
    const ItemVisitor<Visit> item("extensions", label, visit);
    const ArmEffect& effect = *findArmEffect(extension.effect);
    for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
      const ArmEffectParameter& p = effect.parameters[i];
      if (p.fitted) item(p.name, p.unit, p.range, extension.parameters[i].value, p.size);
    }
  }
}

std::pair<std::string_view, std::string_view> splitFirst(std::string_view path) {
  const auto dot = path.find('.');
  if (dot == std::string_view::npos) return {path, {}};
  return {path.substr(0, dot), path.substr(dot + 1)};
}

/// The smallest number a model file may hold; where 0 itself may not stand, one that is as good as 0.
double smallest(const Range& range) { return range.lower_open ? range.lower + 1e-12 : range.lower; }

/// What the model does not have, such as the friction of a joint without any: on a log scale there is no way to it, and
/// a pattern of many means those that are there.
bool isAbsent(const ParameterSpace::Choice& choice, double value) {
  return value == 0.0 && choice.lower.value_or(0.0) > 0.0 && choice.pattern.find('*') != std::string::npos;
}

SearchParameter makeParameter(const std::string& name, const ParameterKind& kind, double value,
                              const ParameterSpace::Choice& choice) {
  const double lower = std::max(choice.lower.value_or(-kInfinity), smallest(kind.range));
  const double upper = std::min(choice.upper.value_or(kInfinity), kind.range.upper);
  SearchParameter parameter{{name, std::string(kind.unit), lower, upper}, value, choice.step, choice.prior_sd};
  if (choice.prior_sd_percent) {
    if (value == 0.0) {
      throw ConfigError(
          fmt::format("parameters: pattern '{}': {} is 0 {} in the model, of which {} % are nothing; "
                      "expected prior_sd",
                      choice.pattern, name, kind.unit, *choice.prior_sd_percent));
    }
    parameter.prior_sd = 0.01 * *choice.prior_sd_percent * std::abs(value);
  }
  if (value < parameter.lower || value > parameter.upper) {
    throw ConfigError(fmt::format("parameters: pattern '{}': {} is {} {} in the model, outside its range [{}, {}]",
                                  choice.pattern, name, value, kind.unit, parameter.lower, parameter.upper));
  }
  return parameter;
}

}  // namespace

std::string ParameterPath::str() const {
  std::string path(group);
  if (!item.empty()) path.append(".").append(item);
  if (!member.empty()) path.append(".").append(member);
  if (component >= 0) path.append(".").push_back(static_cast<char>('x' + component));
  return path;
}

void visitParameters(ArmModel& model, const ParameterVisitor& visit) { traverse(model, visit); }

bool matchesPattern(std::string_view pattern, std::string_view path) {
  while (!pattern.empty()) {
    if (path.empty()) return false;
    const auto [wanted, pattern_rest] = splitFirst(pattern);
    const auto [part, path_rest] = splitFirst(path);
    if (wanted == "*" && !pattern_rest.empty() && matchesPattern(pattern, path_rest)) return true;
    if (!matchesGlob(wanted, part)) return false;
    pattern = pattern_rest;
    path = path_rest;
  }
  return true;
}

std::vector<ParameterSpace::Choice> ParameterSpace::readChoices(const YamlNode& list) {
  std::vector<Choice> choices;
  for (const YamlNode& node : list.items()) {
    Choice choice;
    choice.pattern = node.at("pattern").text();
    if (choice.pattern.empty()) node.at("pattern").fail("found an empty text, which would match every number");
    choice.step = node.at("step").number(kPositive);
    if (const auto lower = node.find("lower")) choice.lower = lower->number();
    if (const auto upper = node.find("upper")) choice.upper = upper->number();
    if (choice.lower && choice.upper && *choice.lower > *choice.upper) {
      node.fail(fmt::format("lower {} is above upper {}", *choice.lower, *choice.upper));
    }
    if (const auto sd = node.find("prior_sd")) choice.prior_sd = sd->number(kPositive);
    if (const auto percent = node.find("prior_sd_percent")) choice.prior_sd_percent = percent->number(kPositive);
    if (const auto together = node.find("together")) choice.together = together->boolean();
    if (choice.together && !choice.prior_sd_percent)
      node.fail("found together without prior_sd_percent, expected both");
    if (choice.prior_sd && choice.prior_sd_percent) node.fail("found both prior_sd and prior_sd_percent, expected one");
    if (const auto only = node.find("only")) choice.only = only->text();
    choices.push_back(std::move(choice));
  }
  if (choices.empty()) list.fail("found no parameter, expected at least one pattern");
  return choices;
}

ParameterSpace::ParameterSpace(const ArmModel& model, const std::vector<Choice>& choices) {
  ArmModel copy = model;
  const ArmSizes arm = sizesOf(model);
  std::vector<bool> used(choices.size());
  std::vector<std::optional<std::size_t>> shared(choices.size());  // the parameter of a choice that is one together
  std::size_t position = 0;
  traverse(copy, [&](const ParameterPath& path, const ParameterKind& kind, double& value) {
    const std::string name = path.str();
    const Choice* chosen = nullptr;
    for (std::size_t c = 0; c < choices.size(); ++c) {
      if (!matchesPattern(choices[c].pattern, name)) continue;
      used[c] = true;
      if (chosen) {
        throw ConfigError(fmt::format("parameters: {} is matched by both '{}' and '{}', expected one pattern", name,
                                      chosen->pattern, choices[c].pattern));
      }
      chosen = &choices[c];
    }
    if (chosen && !isAbsent(*chosen, value) && matchesPattern(chosen->only, name)) {
      std::optional<std::size_t>& one = shared[chosen - choices.data()];
      if (!chosen->together || !one) {
        one = parameters_.size();
        const ParameterKind here{kind.unit, rangeOn(kind.range, kind.size, arm), kind.size};
        parameters_.push_back(makeParameter(chosen->together ? chosen->pattern : name, here, value, *chosen));
      }
      const double initial = parameters_[*one].initial;
      numbers_.push_back({position, *one, value == initial ? 1.0 : value / initial});
      if (!std::isfinite(numbers_.back().ratio)) {
        throw ConfigError(
            fmt::format("parameters: pattern '{}': {} is {} and the first that matches is 0: they cannot "
                        "change in proportion, expected together: false",
                        chosen->pattern, name, value));
      }
    }
    ++position;
  });
  for (std::size_t c = 0; c < choices.size(); ++c) {
    if (!used[c]) {
      throw ConfigError(fmt::format("parameters: pattern '{}' matches nothing in the model", choices[c].pattern));
    }
  }
  if (parameters_.empty() && !choices.empty()) {
    throw ConfigError(fmt::format("only '{}': found no such number among those of parameters, expected at least one",
                                  choices.front().only));
  }
}

std::vector<std::size_t> ParameterSpace::owners() const {
  std::vector<std::size_t> owners;
  for (const Number& number : numbers_) owners.push_back(number.parameter);
  return owners;
}

void ParameterSpace::forEachChosen(ArmModel& model,
                                   const std::function<void(const Number& number, double& value)>& action) const {
  std::size_t position = 0, next = 0;
  traverse(model, [&](const ParameterPath&, const ParameterKind&, double& value) {
    if (next < numbers_.size() && numbers_[next].position == position) action(numbers_[next++], value);
    ++position;
  });
}

void ParameterSpace::apply(std::span<const double> values, ArmModel& model) const {
  forEachChosen(model, [&](const Number& number, double& value) { value = number.ratio * values[number.parameter]; });
}

std::vector<double> ParameterSpace::values(ArmModel model) const {
  std::vector<double> values(parameters_.size());
  forEachChosen(model, [&](const Number& number, double& value) {
    if (number.ratio != 0.0) values[number.parameter] = value / number.ratio;
  });
  return values;
}

}  // namespace simgap
