/// \file
/// Friction of the braid opposes the change of length, in proportion to the pressure that presses it together:
///
///     f -= h p sign(d eps / dt),
///
/// or, as bristles that are dragged along and bend before they slip (Dahl 1968), also without pressure:
///
///     f -= (friction + h p) z,   dz/dx = (sign(dx) - z) / slip,   x: contraction, or pressure at a fixed length, as a
///                                                                    share of the session's range.
#include <cmath>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::contraction_hysteresis {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "h", .unit = "m2", .lower = 0.0, .torque = false}};
constexpr EffectParameter kBristleParameters[] = {{"slip", "1", 1e-4, 2.0, 1.0, 0.05, EffectParameter::Kind::kShape}};
constexpr EffectColumn kBristleColumns[] = {{.name = "friction", .unit = "A", .lower = 0.0, .torque = false},
                                            {.name = "h", .unit = "m2", .lower = 0.0, .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -rows.direction * terms.pressure;
}

void fillBristle(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
                 const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  double bent = 0.0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double d = rows.direction[i];
    const bool begins = i == 0 || rows.session[k] != rows.session[k - 1];
    bent = begins ? d : d + (bent - d) * std::exp(-rows.travel[i] / p[0]);
    x(i, 0) = -bent;
  }
  x.col(1) = x.col(0) * terms.pressure;
}

std::vector<std::vector<double>> bristleStarts(const ActuatorRows& /*rows*/, const Eigen::ArrayXd& /*residual*/) {
  return {{0.005}, {0.02}, {0.1}, {0.3}};
}

constexpr ActuatorEffect kUsual = {
    .name = "contraction-hysteresis",
    .form = "sign",
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

constexpr ActuatorEffect kBristle = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "bristle";
  effect.equation = "f -= (friction + h p) z, dz/dx = (sign(dx) - z) / slip";
  effect.parameters = kBristleParameters;
  effect.columns = kBristleColumns;
  effect.remembers = effect.needs_all_rows = true;
  effect.fill = fillBristle;
  effect.starts = bristleStarts;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kBristle};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::contraction_hysteresis
