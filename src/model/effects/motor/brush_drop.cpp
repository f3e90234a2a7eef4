/// \file
/// Brushes drop a nearly constant voltage against the current: V += V_b sign(i), smooth within a fiftieth of the usual
/// current, and within its noise, which would decide the sign and thin out the drop.
#include "simgap/model/effects/actuator_effect.h"

#include <algorithm>
#include <cmath>

namespace simgap::actuator_effects::brush_drop {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "V_b", .unit = "V", .lower = 0.0, .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  constexpr double kNoise = 3.5;  // standard deviations
  const double usual = std::sqrt(rows.current.square().mean());
  const double small = std::max(0.02 * usual, kNoise * rows.current_noise) + 1e-12;
  x.col(0) = (rows.current / small).tanh();
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "brush-drop",
    .kind = ActuatorKind::kMotor,
    .cause = "the brushes drop a nearly constant voltage against the current",
    .equation = "V += V_b sign(i)",
    .signature = "residual x sign(current) has one height at all currents",
    .source = "Hughes & Drury 2013, chapter 3",
    .look_alikes = "winding-heating over one range of currents, an offset of the current sensor",
    .separates = "slow ramps of the current through zero with the shaft held",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::brush_drop
