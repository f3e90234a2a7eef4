/// Variant A with static friction left at zero load too.
///
///     tau_fr = [n_c1 |tau| + n_c2 + ((n_s1 - n_c1) |tau| + n_s2 - n_c2) exp(-|w/v_s|^delta)] sign(w) + k_v w
///
/// Source: 003 eq. 4, 9, 11.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::variant_b {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"n_c1", FrictionBasis::kLoad, FrictionShape::kSliding},
    {"n_c2", FrictionBasis::kDirection, FrictionShape::kSliding},
    {"n_s1", FrictionBasis::kLoad, FrictionShape::kStatic},
    {"n_s2", FrictionBasis::kDirection, FrictionShape::kStatic},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c1 = theta[0], .n_c2 = theta[1], .n_s1 = theta[2], .n_s2 = theta[3], .k_v = theta[4]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "variant-b",
    .summary = "variant A with static friction left at zero load too",
    .equation = "[n_c1 |tau| + n_c2 + ((n_s1 - n_c1) |tau| + n_s2 - n_c2) exp(-|w/v_s|^delta)] sign(w) + k_v w",
    .source = "003 eq. 4, 9, 11",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::variant_b
