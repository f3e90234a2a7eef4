/// \file
/// The winding warms up and its resistance grows: V += dR u i. u is the logged temperature from its coldest (0) to its
/// warmest (1) or, without one, a thermal state that follows the losses, du/dt = (i^2 / mean(i^2) - u) / tau.
#include "simgap/model/effects/actuator_effect.h"

#include <algorithm>
#include <cmath>

namespace simgap::actuator_effects::winding_heating {
namespace {

constexpr EffectParameter kParameters[] = {{"tau", "s", 1.0, 1e4, 100.0, 100.0, EffectParameter::Kind::kShape}};
constexpr EffectColumn kColumns[] = {{.name = "dR", .unit = "ohm", .lower = 0.0, .torque = false}};

Eigen::ArrayXd warmth(double tau, const ActuatorRows& rows) {
  if (rows.temperature.size() > 0) {
    const double cold = rows.temperature.minCoeff();
    return (rows.temperature - cold) / std::max(rows.temperature.maxCoeff() - cold, 1e-9);
  }
  const double mean = std::max(rows.current.square().mean(), 1e-300);
  Eigen::ArrayXd u = Eigen::ArrayXd::Zero(rows.rows());
  for (Eigen::Index i = 1; i < rows.rows(); ++i) {
    const double dt = rows.time[i] - rows.time[i - 1];
    // A new clock is a new, cold start.
    u[i] = dt <= 0.0
               ? 0.0
               : u[i - 1] + (rows.current[i - 1] * rows.current[i - 1] / mean - u[i - 1]) * -std::expm1(-dt / tau);
  }
  return u;
}

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.current * warmth(p[0], rows);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  if (rows.temperature.size() > 0) return {{kParameters[0].start}};  // it plays no part
  const double span = rows.step * static_cast<double>(rows.rows());
  return {{std::max(0.02 * span, 1.0)}, {std::max(0.1 * span, 1.0)}, {std::max(0.5 * span, 1.0)}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "winding-heating",
    .kind = ActuatorKind::kMotor,
    .cause = "the winding warms up and its resistance grows",
    .equation =
        "V += dR u i, u: logged temperature, 0 at its coldest and 1 at its warmest, or du/dt = (i^2 / mean(i^2) - u) / "
        "tau",
    .signature = "residual x current grows over minutes of large current and falls in rest",
    .source = "000 eq. 8; copper: 0.39 % per K",
    .look_alikes = "brush-drop, anything that drifts with time",
    .separates = "the shaft held at one current for minutes, then cooling and again",
    .parameters = kParameters,
    .columns = kColumns,
    .of_rows = true,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::winding_heating
