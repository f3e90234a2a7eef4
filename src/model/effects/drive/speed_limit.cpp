/// \file
/// Voltage headroom: near the speed at which the back-EMF eats the supply, what is commanded grows without effect. The
/// logged effort then exceeds what the motion needs by a term that sets in at a speed w_limit:
///
///     effort += c max(0, |w| - w_limit) sign(w)
///
/// or, where the effort is a command that the supply cuts off, its part for the speed stops growing there:
///
///     k_v w (1 + (|w| / w_limit)^16)^(-1/16)      about k_v min(|w|, w_limit) sign(w), but smooth
#include <algorithm>
#include <vector>

#include "simgap/core/statistics.h"

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::speed_limit {
namespace {

constexpr EffectParameter kParameters[] = {{"w_limit", "rad_s", 0.0, 1e6, 0.0, 0.0, EffectParameter::Kind::kScanned}};
constexpr EffectColumn kColumns[] = {{.name = "c", .unit = "A_s_rad", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = (rows.speed.abs() - p[0]).max(0.0) * rows.direction;
}

/// Knees in the upper half of the speeds: a limit is met, or it is none.
std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (int k = 0; k < 10; ++k) list.push_back({rows.top_speed * (0.5 + 0.05 * k)});
  return list;
}

constexpr EffectParameter kCeilingParameters[] = {
    {"w_limit", "rad_s", 1e-6, 1e6, 1e6, 1e6, EffectParameter::Kind::kShape}};

void applyCeiling(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  constexpr double kSharp = 16.0;
  terms.viscous *= (1.0 + (rows.speed.abs() / p[0]).min(1e6).pow(kSharp)).pow(-1.0 / kSharp);
}

/// A ceiling is seen: beyond the limit the effort stands at its largest, but for how far a supply sags, more often than
/// not, and seldom below it (a constant force would always). Without one a viscous term that saturates is
/// `viscous-nonlinearity`.
bool standsAtItsCeiling(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kSag = 0.05, kMostly = 0.5, kSeldom = 0.2;
  std::vector<double> sizes(static_cast<std::size_t>(rows.rows()));
  for (Eigen::Index i = 0; i < rows.rows(); ++i) sizes[i] = std::abs(rows.effort[i]);
  const double ceiling = (1.0 - kSag) * quantile(std::move(sizes), 0.99);
  const Eigen::ArrayXd fast = (rows.speed.abs() > p[0]).cast<double>();
  const Eigen::ArrayXd at_ceiling = (rows.effort * rows.direction > ceiling).cast<double>();
  const double beyond = (fast * at_ceiling).sum(), below = ((1.0 - fast) * at_ceiling).sum();
  return beyond > kMostly * fast.sum() && below < kSeldom * (1.0 - fast).sum();
}

constexpr ActuatorEffect kUsual = {
    .name = "speed-limit",
    .form = "effort",
    .cause = "the supply limits the speed: beyond it more effort moves nothing faster",
    .equation = "effort += c max(0, |w| - w_limit) sign(w)",
    .signature = "nothing below a speed, then effort without motion",
    .source = "voltage headroom of a DC motor: V = R i + K_E w, |V| <= supply",
    .look_alikes = "viscous-nonlinearity, torque-saturation",
    .separates = "the same motion at a higher and at a lower supply voltage",
    .parameters = kParameters,
    .columns = kColumns,
    .fill = fill,
    .starts = starts,
};

constexpr ActuatorEffect kCeiling = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "ceiling";
  effect.equation = "k_v w (1 + |w / w_limit|^16)^(-1/16)";
  effect.parameters = kCeilingParameters;
  effect.columns = {};
  effect.fill = nullptr;
  effect.apply = applyCeiling;
  effect.counts = standsAtItsCeiling;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kCeiling};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::speed_limit
