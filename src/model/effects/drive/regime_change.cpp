/// \file
/// Something was altered at one moment t_c (a cable re-tensioned, slipped): from then on dry friction x (1 + a) and
/// the effort + I_1.
#include <algorithm>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::regime_change {
namespace {

constexpr EffectParameter kParameters[] = {{"a", "1", -0.9, 3.0, 0.0, 0.0},
                                           {"t_c", "s", -1e12, 1e12, 0.0, 0.0, EffectParameter::Kind::kScanned}};
constexpr EffectColumn kColumns[] = {{.name = "I_1", .unit = "A", .torque = false}};

Eigen::ArrayXd after(std::span<const double> p, const ActuatorRows& rows) {
  return (rows.elapsed >= p[1]).cast<double>();
}

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= 1.0 + p[0] * after(p, rows);
}

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = after(p, rows);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double begin = rows.elapsed[0], length = rows.elapsed[rows.rows() - 1] - begin;
  std::vector<std::vector<double>> list;
  for (int k = 2; k <= 38; ++k) list.push_back({0.0, begin + length * k / 40.0});
  return list;
}

/// What holds from next to the log's beginning on is a bias, and next to its end it is a piece of it.
bool counts(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFewestRows = 0.08;
  const double before = (rows.elapsed < p[1]).cast<double>().mean();
  return std::min(before, 1.0 - before) >= kFewestRows;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "regime-change",
    .cause = "something was altered at one moment: a cable re-tensioned or slipped",
    .equation = "tau_dry (1 + a) and I + I_1 from t_c on",
    .signature = "a residual that changes once, at one moment",
    .remarks =
        "The moment t_c counts from the log's beginning: a session whose clock begins anew follows the one before it",
    .source = "catalogue of causes",
    .look_alikes = "friction-heating and other drifts in time",
    .separates = "the first motion of the log once more at its end",
    .parameters = kParameters,
    .columns = kColumns,
    .at_moment = true,
    .apply = apply,
    .fill = fill,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::regime_change
