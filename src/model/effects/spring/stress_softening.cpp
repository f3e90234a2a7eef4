/// \file
/// A spring of rubber or textile is softer up to where it has been stretched before (Mullins 1969): with e the
/// deflection from where there is no force and E the furthest |e| up to now, over all sessions,
///
///     F -= s e (1 - |e| / E),        the first stretch is met again at E;   or
///     F -= s e E / reach,            bonds that break at lengths of their own stay broken.
///
/// s is the stiffness that is lost: near rest, or at the largest deflection of the log.
#include "../deflection_sides.h"

namespace simgap::actuator_effects::stress_softening {
namespace {

constexpr EffectParameter kParameters[] = {{"rejoins", "1", 0.0, 1.0, 1.0, 1.0, EffectParameter::Kind::kConstant},
                                           {"origin", "rad", -100.0, 100.0, 0.0, 0.0, EffectParameter::Kind::kConstant},
                                           kReach};
constexpr EffectColumn kColumns[] = {{.name = "softening", .unit = "Nm_rad", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  double furthest = 1e-3 * p[2];
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double e = terms.deflection[i] - p[1];
    furthest = std::max(furthest, std::abs(e));
    x(i, 0) = -e * (p[0] > 0.5 ? 1.0 - std::abs(e) / furthest : furthest / p[2]);
  }
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double origin = unloadedDeflection(rows);
  const double reach = furthestDeflection(rows, origin);
  return {{1.0, origin, reach}, {0.0, origin, reach}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "stress-softening",
    .kind = ActuatorKind::kSpring,
    .cause =
        "the spring is softer up to where it has been stretched before: rubber and textiles remember their "
        "furthest stretch",
    .equation = "F -= s e (1 - abs(e) / E) or s e E / reach, E: the furthest abs(e) so far",
    .signature = "the first stretch is stiffer than all later ones of that length",
    .remarks =
        "the data choose whether the first curve is met again at the furthest stretch (`rejoins` = 1) or what "
        "broke stays broken (0)",
    .source = "Mullins 1969",
    .look_alikes = "spring-hardening and spring-softening when no stretch goes beyond the one before; spring-creep",
    .separates = "a new spring stretched further and further, twice to each length",
    .parameters = kParameters,
    .columns = kColumns,
    .remembers = true,
    .needs_all_rows = true,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::stress_softening
