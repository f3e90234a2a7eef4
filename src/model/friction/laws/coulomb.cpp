/// Dry and viscous friction, whatever the load.
///
///     tau_fr = tau_c sign(w) + k_v w
///
/// Source: Coulomb 1785; Armstrong-Helouvry et al. 1994, section 2.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::coulomb {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"tau_c", FrictionBasis::kDirection, FrictionShape::kAlways},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c2 = theta[0], .n_s2 = theta[0], .k_v = theta[1]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "coulomb",
    .summary = "dry and viscous friction, whatever the load",
    .equation = "tau_c sign(w) + k_v w",
    .source = "Coulomb 1785; Armstrong-Helouvry et al. 1994, section 2",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::coulomb
