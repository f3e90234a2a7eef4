/// Dry friction that grows with the load, and viscous friction.
///
///     tau_fr = (n_c1 |tau| + n_c2) sign(w) + k_v w
///
/// Source: 003 eq. 9 without the Stribeck term.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::load_coulomb {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"n_c1", FrictionBasis::kLoad, FrictionShape::kAlways},
    {"n_c2", FrictionBasis::kDirection, FrictionShape::kAlways},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c1 = theta[0], .n_c2 = theta[1], .n_s1 = theta[0], .n_s2 = theta[1], .k_v = theta[2]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "load-coulomb",
    .summary = "dry friction that grows with the load, and viscous friction",
    .equation = "(n_c1 |tau| + n_c2) sign(w) + k_v w",
    .source = "003 eq. 9 without the Stribeck term",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::load_coulomb
