/// \file
/// Friction that differs between driving a load and being driven by it: the whole friction x (1 + b sign(tau_ext w)).
/// On a friction proportional to the load alone it is exactly a change of k_a (|tau| sign(w) sign(tau w) = tau).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::backdrive_asymmetry {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoad};
constexpr EffectParameter kParameters[] = {{"b", "1", -0.9, 0.9, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd factor = 1.0 + p[0] * (terms.load * rows.direction).sign();
  terms.dry *= factor;
  terms.viscous *= factor;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "backdrive-asymmetry",
    .cause = "friction that differs between driving a load and being driven by it",
    .equation = "tau_fr (1 + b sign(tau_ext w))",
    .signature = "residuals that differ between the quadrants of the power flow",
    .remarks =
        "on a friction proportional to the load alone it is exactly a change of k_a, and then a diagnosis says so "
        "instead of naming it",
    .source = "catalogue of causes",
    .look_alikes = "torque-constant of the drive (k_a), direction-asymmetry, coulomb-offset",
    .separates = "lifting and lowering of several loads at several speeds",
    .parameters = kParameters,
    .needs = kNeeds,
    .of_load_sign = true,
    .on_gearbox = false,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::backdrive_asymmetry
