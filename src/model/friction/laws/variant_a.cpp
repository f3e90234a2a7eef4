/// The classic model with Coulomb friction left at zero load (adhesion, preload).
///
///     tau_fr = [n_c1 |tau| + n_c2 + (n_s |tau| - n_c1 |tau| - n_c2) exp(-|w/v_s|^delta)] sign(w) + k_v w
///
/// Source: 003 eq. 4, 8, 9.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::variant_a {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"n_c1", FrictionBasis::kLoad, FrictionShape::kSliding},
    {"n_c2", FrictionBasis::kDirection, FrictionShape::kSliding},
    {"n_s", FrictionBasis::kLoad, FrictionShape::kStatic},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c1 = theta[0], .n_c2 = theta[1], .n_s1 = theta[2], .k_v = theta[3]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "variant-a",
    .summary = "the classic model with Coulomb friction left at zero load (adhesion, preload)",
    .equation = "[n_c1 |tau| + n_c2 + (n_s |tau| - n_c1 |tau| - n_c2) exp(-|w/v_s|^delta)] sign(w) + k_v w",
    .source = "003 eq. 4, 8, 9",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::variant_a
