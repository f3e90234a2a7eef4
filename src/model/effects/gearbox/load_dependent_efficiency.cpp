/// \file
/// A gearbox loses a share of what it transmits, whichever way power flows: i k_a = tau + e |tau| sign(w). The constant
/// efficiency of 000 eq. 11 also multiplies when the gear is driven backwards, which real gears do not.
#include "simgap/model/drive_effect.h"

namespace simgap::drive_effects {
namespace {

constexpr EffectColumn kColumns[] = {{"e", "1", 0.0}};

void fill(std::span<const double> /*p*/, const DriveRows& /*rows*/, const DriveTerms& terms,
          const Eigen::ArrayXd& /*still*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
}

}  // namespace

extern const DriveEffect load_dependent_efficiency;
const DriveEffect load_dependent_efficiency = {
    .name = "load-dependent-efficiency",
    .kind = DriveKind::kGearbox,
    .cause = "the gearbox loses a share of what it transmits, whichever way power flows",
    .equation = "tau += e |tau_ext| sign(w)",
    .source = "000 eq. 11; Wang et al. 2011 (planetary gears)",
    .look_alikes = "exactly a larger k_a when the drive is never driven backwards",
    .separates = "the same loads lifted and lowered",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::drive_effects
