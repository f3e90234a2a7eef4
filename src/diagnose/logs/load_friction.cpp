#include "load_friction.h"

#include "simgap/model/friction/friction_law.h"

namespace simgap {
namespace {

constexpr EffectColumn kLoadColumns[] = {{"n_1", "1"}, {"n_2", "1_Nm"}};

void fillLoad(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
              const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
  x.col(1) = terms.load.square() * terms.dry;
}

/// A part of a law that differs from a simpler one by the load alone.
bool isByTheLoad(const ActuatorEffect& effect) {
  return effect.contained_in != nullptr && effect.contained_in(friction::find("load-coulomb")) &&
         !effect.contained_in(friction::find("coulomb"));
}

}  // namespace

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

std::optional<BesideLoad> besideLoadFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                             const ActuatorEffect& cause) {
  const FrictionLaw* law = search.base().law;
  const bool known = search.data().rows.has(OptionalChannel::kLoad) && !search.data().fits_weight;
  // A gearbox loses by the load, too, but that is a cause of its own there.
  const bool drive = search.base().kind == ActuatorKind::kFriction;
  if (law == nullptr || !drive || law->needsLoad() || !known || isByTheLoad(cause)) return std::nullopt;
  const Hypothesis load{&kLoadFriction, {}, {}};
  // Each from the other's end as well: a curve that stays where it was would be the cause's gain.
  const Fitted first = search.beside(full, load);
  const Fitted without = search.beside(rest, load, &first);
  return BesideLoad{without, search.beside(full, load, &without)};
}

}  // namespace simgap
