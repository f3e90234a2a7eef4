/// \file
/// Breakaway friction that grows with the time at rest: tau_s += c log(1 + t_rest / 1 s).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kRest};
constexpr EffectColumn kColumns[] = {{"c", "Nm", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.dry * stribeck * (1.0 + rows.rest).log();
}

}  // namespace

extern const ActuatorEffect stiction_ageing;
const ActuatorEffect stiction_ageing = {
    .name = "stiction-ageing",
    .cause = "breaking away takes more the longer the drive has rested",
    .equation = "tau_s += c log(1 + t_rest / 1 s)",
    .signature = "breakaway peaks that grow with the rest before them",
    .source = "catalogue of causes",
    .look_alikes = "static-offset, presliding-hysteresis",
    .separates = "rests of 1, 3 and 10 s under load before slow motion",
    .columns = kColumns,
    .needs = kNeeds,
    .needs_stribeck = true,
    .fill = fill,
};

}  // namespace simgap::actuator_effects
