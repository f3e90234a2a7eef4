/// \file
/// A gearbox loses a share of what it transmits, whichever way power flows: i k_a = tau + e |tau| sign(w). The constant
/// efficiency of 000 eq. 11 also multiplies when the gear is driven backwards, which real gears do not.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::load_dependent_efficiency {
namespace {

constexpr EffectColumn kColumns[] = {{"e", "1", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "load-dependent-efficiency",
    .kind = ActuatorKind::kGearbox,
    .cause = "the gearbox loses a share of what it transmits, whichever way power flows",
    .equation = "tau += e |tau_ext| sign(w)",
    .signature = "residual x direction grows with the load, lifting and lowering",
    .source = "000 eq. 11; catalogue of causes",
    .look_alikes = "exactly a larger k_a when the drive is never driven backwards",
    .separates = "the same loads lifted and lowered",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::load_dependent_efficiency
