#include "slow_friction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simgap/core/statistics.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr Index kKnots = 4;  // at w_slow / 2, / 4, / 8 and / 16, below which the line is level

constexpr EffectParameter kSlowParameters[] = {{"w_slow", "rad_s", 1e-12, 1e9, 1.0, 1.0, Kind::kConstant},
                                               {"constant", "1", 0.0, 1.0, 1.0, 1.0, Kind::kConstant},
                                               {"per_load", "1", 0.0, 1.0, 1.0, 1.0, Kind::kConstant}};
constexpr EffectColumn kSlowColumns[] = {{"c_1", "Nm"}, {"c_2", "Nm"}, {"c_3", "Nm"}, {"c_4", "Nm"},
                                         {"n_1", "1"},  {"n_2", "1"},  {"n_3", "1"},  {"n_4", "1"}};

void fillSlow(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
              const ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const ArrayXd octaves = (rows.speed.abs() / p[0]).max(1e-9).log2().max(-static_cast<double>(kKnots));
  for (Index k = 0; k < kKnots; ++k) {
    const ArrayXd hat = (1.0 - (octaves + static_cast<double>(k + 1)).abs()).max(0.0);
    x.col(k) = p[1] * terms.dry * hat;
    x.col(kKnots + k) = p[2] * terms.load.abs() * terms.dry * hat;
  }
}

/// A quarter of the speed of fast motion: where a law's own Stribeck curve ends says little, for real ones have tails.
double slowBelow(const LogSearch& search) {
  constexpr double kFast = 0.95, kMost = 0.25;
  const ActuatorData& data = search.data();
  std::vector<double> speeds;
  for (Index i = 0; i < data.rows.rows(); ++i) {
    if (data.keep[i]) speeds.push_back(std::abs(data.rows.speed[i]));
  }
  return kMost * quantile(std::move(speeds), kFast);
}

}  // namespace

const ActuatorEffect kSlowFriction = {
    .name = "slow-friction",
    .cause = "friction in slow motion that follows no closed form",
    .equation = "tau_fr += c(log |w|) sign(w), n(log |w|) |tau_ext| sign(w)",
    .signature = "structure over the speed of slow motion",
    .source = "not a cause: what causes have to stand beside",
    .look_alikes = "",
    .separates = "constant slow speeds",
    .parameters = kSlowParameters,
    .columns = kSlowColumns,
    .fill = fillSlow,
};

std::optional<BesideSlow> besideSlowFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                             bool of_any_load) {
  if (search.base().law == nullptr) return std::nullopt;
  const FrictionLaw& law = *search.base().law;
  const auto has = [&](FrictionBasis basis) {
    const bool bent = law.hasTerm(basis, FrictionShape::kStatic) || law.hasTerm(basis, FrictionShape::kSliding);
    return of_any_load || bent || (!law.hasStribeck() && law.hasTerm(basis, FrictionShape::kAlways)) ? 1.0 : 0.0;
  };
  const double below = slowBelow(search);
  const Hypothesis slow{&kSlowFriction, {}, {below, has(FrictionBasis::kDirection), has(FrictionBasis::kLoad)}};
  // Each from the other's end as well: a Stribeck curve that stays where it was would be the cause's gain.
  const Fitted first = search.beside(full, slow);
  const Fitted without = search.beside(rest, slow, &first);
  return BesideSlow{{without, search.beside(full, slow, &without)}, below};
}

}  // namespace simgap
