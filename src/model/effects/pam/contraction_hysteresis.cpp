/// \file
/// Friction of the braid opposes the change of length, in proportion to the pressure that presses it together:
///
///     f -= h p sign(d eps / dt)
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::contraction_hysteresis {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "h", .unit = "m2", .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -rows.direction * terms.pressure;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "contraction-hysteresis",
    .kind = ActuatorKind::kPam,
    .cause = "friction of the braid opposes the change of length (of pressure, at a fixed length)",
    .equation = "f -= h p sign(d eps / dt)",
    .signature = "force over contraction runs round a loop whose width grows with pressure",
    .source = "Chou & Hannaford 1996; Tondu & Lopez 2000",
    .look_alikes = "a valve's lag, when only one direction is recorded",
    .separates = "the same lengths and pressures reached from both sides, slowly",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::contraction_hysteresis
