/// \file
/// Breakaway friction that grows with the time at rest: tau_s += c log(1 + t_rest / 1 s), or as a power of it.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::stiction_ageing {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kRest};
constexpr EffectColumn kColumns[] = {{"c", "Nm", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.dry * stribeck * (1.0 + rows.rest).log();
}

void fillPower(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& terms,
               const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  constexpr double kExponent = 0.4;
  x.col(0) = terms.dry * stribeck * rows.rest.pow(kExponent);
}

constexpr ActuatorEffect kUsual = {
    .name = "stiction-ageing",
    .form = "logarithm",
    .cause = "breaking away takes more the longer the drive has rested",
    .equation = "tau_s += c log(1 + t_rest / 1 s)",
    .signature = "breakaway peaks that grow with the rest before them",
    .source = "catalogue of causes",
    .look_alikes = "static-offset, presliding-hysteresis",
    .separates = "rests of 1, 3 and 10 s under load before slow motion",
    .columns = kColumns,
    .needs = kNeeds,
    .needs_stribeck = true,
    .remembers = true,
    .fill = fill,
};

constexpr ActuatorEffect kPower = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "power";
  effect.equation = "tau_s += c (t_rest / 1 s)^0.4";
  effect.fill = fillPower;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kPower};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::stiction_ageing
