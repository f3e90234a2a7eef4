#include "load_friction.h"

#include <algorithm>

#include "simgap/model/friction/friction_law.h"

namespace simgap {
namespace {

constexpr EffectColumn kLoadColumns[] = {{"n_1", "1"}, {"n_2", "1_Nm"}};

void fillLoad(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
              const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
  x.col(1) = terms.load.square() * terms.dry;
}

bool goesWithLoad(const EffectColumn& column) { return column.unit.starts_with("1"); }

}  // namespace

bool isByTheLoad(const ActuatorEffect& effect) {
  return effect.contained_in != nullptr && effect.contained_in(friction::find("load-coulomb")) &&
         !effect.contained_in(friction::find("coulomb"));
}

const ActuatorEffect kLoadFriction = {
    .name = "load-friction",
    .cause = "friction that grows with the load",
    .equation = "tau_fr += (n_1 |tau_ext| + n_2 tau_ext^2) sign(w)",
    .signature = "steps at reversals that grow with the load",
    .source = "not a cause: what causes have to stand beside under a law without it",
    .look_alikes = "",
    .separates = "the same motion under several loads",
    .columns = kLoadColumns,
    .fill = fillLoad,
};

bool lacksLoadFriction(const LogSearch& search, const ActuatorEffect& cause) {
  const FrictionLaw* law = search.base().law;
  const bool known = search.data().rows.has(OptionalChannel::kLoad) && !search.data().fits_weight;
  // A gearbox loses by the load, too, but that is a cause of its own there.
  const bool drive = search.base().kind == ActuatorKind::kFriction;
  return law != nullptr && drive && !law->needsLoad() && known && !isByTheLoad(cause);
}

std::optional<Beside> besideLoadFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                         const ActuatorEffect& cause) {
  if (!lacksLoadFriction(search, cause)) return std::nullopt;
  const Hypothesis load{&kLoadFriction, {}, {}};
  // Each from the other's end as well: a curve that stays where it was would be the cause's gain.
  const Fitted first = search.beside(full, load);
  const Fitted without = search.beside(rest, load, &first);
  return Beside{without, search.beside(full, load, &without)};
}

bool isMostlyByTheLoad(const LogSearch& search, const Fitted& full, std::size_t effect) {
  constexpr double kMostly = 2.0;
  const ActuatorEffect& cause = *full.model->effects()[effect];
  const bool mixed =
      std::ranges::any_of(cause.columns, goesWithLoad) && !std::ranges::all_of(cause.columns, goesWithLoad);
  if (!lacksLoadFriction(search, cause) || !mixed) return false;
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  full.model->evaluate(full.theta, residual, &jacobian);
  double by_load = 0.0, constant = 0.0;  // squares of what the terms add
  for (std::size_t k = 0; k < cause.columns.size(); ++k) {
    const std::size_t i = full.model->firstColumn(effect) + k;
    (goesWithLoad(cause.columns[k]) ? by_load : constant) +=
        full.theta[i] * full.theta[i] * jacobian.col(i).squaredNorm();
  }
  return by_load > kMostly * kMostly * constant;
}

}  // namespace simgap
