/// Dry friction that falls with speed, and viscous friction, whatever the load.
///
///     tau_fr = [tau_c + (tau_s - tau_c) exp(-|w/v_s|^delta)] sign(w) + k_v w
///
/// Source: Armstrong-Helouvry et al. 1994, eq. 5; 003 eq. 4 with constant tau_c and tau_s.
#include "simgap/model/friction/friction_law.h"

namespace simgap::friction::stribeck {
namespace {

constexpr FrictionTerm kTerms[] = {
    {"tau_c", FrictionBasis::kDirection, FrictionShape::kSliding},
    {"tau_s", FrictionBasis::kDirection, FrictionShape::kStatic},
    {"k_v", FrictionBasis::kVelocity, FrictionShape::kAlways},
};

StribeckFriction closedForm(std::span<const double> theta) {
  return {.n_c2 = theta[0], .n_s2 = theta[1], .k_v = theta[2]};
}

}  // namespace

extern const FrictionLaw entry;
const FrictionLaw entry{
    .name = "stribeck",
    .summary = "dry friction that falls with speed, and viscous friction, whatever the load",
    .equation = "[tau_c + (tau_s - tau_c) exp(-|w/v_s|^delta)] sign(w) + k_v w",
    .source = "Armstrong-Helouvry et al. 1994, eq. 5; 003 eq. 4 with constant tau_c and tau_s",
    .terms = kTerms,
    .closed_form = closedForm,
};

}  // namespace simgap::friction::stribeck
