/// Stribeck and Coulomb friction, both proportional to the load (the paper's classic model).
///
///     tau_fr = [n_c |tau| + (n_s - n_c) |tau| exp(-|w/v_s|^delta)] sign(w) + k_v w
///
/// Source: 003 eq. 4, 7, 8.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::classic {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"n_c", FrictionBasis::kLoad, FrictionShape::kSliding},
    {"n_s", FrictionBasis::kLoad, FrictionShape::kStatic},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c1 = theta[0], .n_s1 = theta[1], .k_v = theta[2]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "classic",
    .summary = "Stribeck and Coulomb friction, both proportional to the load (the paper's classic model)",
    .equation = "[n_c |tau| + (n_s - n_c) |tau| exp(-|w/v_s|^delta)] sign(w) + k_v w",
    .source = "003 eq. 4, 7, 8",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::classic
