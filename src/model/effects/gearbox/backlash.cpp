/// \file
/// After a reversal the motor turns freely through the teeth's play: over a travel `play` neither load nor the gear's
/// friction reaches it; the teeth meet within a tenth of it.
#include "simgap/model/effects/actuator_effect.h"

#include <algorithm>
#include <cmath>

namespace simgap::actuator_effects::backlash {
namespace {

constexpr EffectParameter kParameters[] = {{"play", "rad", 0.0, 20.0, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  if (p[0] <= 0.0) return;
  double since = 1e9;  // [rad] travel since the last reversal
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool same = i > 0 && rows.session[k] == rows.session[k - 1];
    if (!same) since = 1e9;
    if (same && rows.direction[i] != rows.direction[i - 1]) since = 0.0;
    since += rows.travel[i];
    const double engaged = 0.5 + 0.5 * std::tanh((since - p[0]) / (0.05 * p[0]));
    terms.load[i] *= engaged;
    terms.dry[i] *= engaged;
  }
}

/// The longest travel [rad] in one direction: no more play than this can be told from a drive that carries nothing.
double longestStroke(const ActuatorRows& rows) {
  double longest = 0.0, stroke = 0.0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool goesOn = i > 0 && rows.session[k] == rows.session[k - 1] && rows.direction[i] == rows.direction[i - 1];
    stroke = goesOn ? stroke + rows.travel[i] : rows.travel[i];
    longest = std::max(longest, stroke);
  }
  return longest;
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double stride = rows.top_speed * rows.step, most = std::min(0.5 * longestStroke(rows), 20.0);
  std::vector<std::vector<double>> list;
  for (double play = 0.2 * stride; play < most; play *= 1.8) list.push_back({play});
  return list;
}

constexpr EffectParameter kElastic[] = {{"play", "rad", 0.0, 20.0, 0.0, 0.0},
                                        {"x_c", "rad", 1e-6, 20.0, 0.0, 0.0, EffectParameter::Kind::kShape}};

void applyElastic(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  if (p[0] <= 0.0) return;
  const double free = 0.5 * p[0], contact = p[1], most = free + contact;
  double u = 0.0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double d = rows.direction[i];
    if (i == 0 || rows.session[k] != rows.session[k - 1]) u = d * most;
    u = std::clamp(u + d * rows.travel[i], -most, most);
    terms.dry[i] *= d * std::copysign(std::clamp((std::abs(u) - free) / contact, 0.0, 1.0), u);
  }
}

std::vector<std::vector<double>> startsElastic(const ActuatorRows& rows, const Eigen::ArrayXd& residual) {
  std::vector<std::vector<double>> list;
  for (const std::vector<double>& p : starts(rows, residual)) {
    for (const double share : {0.3, 1.0}) list.push_back({p[0], share * p[0]});
  }
  return list;
}

/// With less play than spring it is what presliding-hysteresis says more simply.
bool mostlyPlay(std::span<const double> p, const ActuatorRows& /*rows*/) { return p[0] > p[1]; }

constexpr ActuatorEffect kUsual = {
    .name = "backlash",
    .form = "hard",
    .kind = ActuatorKind::kGearbox,
    .cause = "after a reversal the motor turns freely through the play of the teeth",
    .equation = "tau_ext = tau_fr = 0 for |travel since the reversal| < play",
    .signature = "the drive needs nothing for a travel after each reversal",
    .source = "Nordin & Gutman 2002",
    .look_alikes = "presliding-hysteresis, channel-delay",
    .separates = "slow reversals under load with many samples in the first travel after each",
    .parameters = kParameters,
    .remembers = true,
    .on_drive = true,
    .apply = apply,
    .starts = starts,
};

constexpr ActuatorEffect kElasticContact = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "elastic";
  effect.equation = "tau_fr sign(u) clamp((|u| - play / 2) / x_c, 0, 1), u: travel held within play / 2 + x_c";
  effect.parameters = kElastic;
  effect.apply = applyElastic;
  effect.starts = startsElastic;
  effect.counts = mostlyPlay;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kElasticContact};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::backlash
