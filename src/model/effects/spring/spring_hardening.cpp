/// \file
/// A spring resists the more, the further it is deflected: with e the deflection from where there is no force,
///
///     F += s e u^(n - 1),   u = |e| / reach,   s >= 0 on either side of its own.
///
/// s is the stiffness (force over deflection) that is gained at the largest deflection of the log.
#include "../deflection_sides.h"

namespace simgap::actuator_effects::spring_hardening {
namespace {

constexpr EffectParameter kParameters[] = {{"exponent", "1", 1.5, 10.0, 2.0, 2.0, EffectParameter::Kind::kShape},
                                           {"saturation", "1", 0.0, 0.0, 0.0, 0.0, EffectParameter::Kind::kConstant},
                                           kBendOrigin,
                                           kReach};
constexpr BendForm kForms[] = {{2.0, 0.0}, {3.0, 0.0}, {5.0, 0.0}};

void fill(std::span<const double> p, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  fillBend(p, terms.deflection, 1.0, x);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return bendStarts(rows, unloadedDeflection(rows), kForms);
}

/// Of a spring that was never let go the place without force lies beyond the log, where exponent and origin take each
/// other's place: it is held where the curve at the least forces leads.
constexpr EffectParameter kPreloadedParameters[] = {
    kParameters[0], kParameters[1], {"origin", "rad", -1e6, 1e6, 0.0, 0.0, EffectParameter::Kind::kConstant}, kReach};

/// None where the log sees the spring let go. The line is that of the quarter of the rows with the least force.
std::vector<std::vector<double>> preloadedStarts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  constexpr double kLetGo = 0.05;  // of the largest force
  const Eigen::ArrayXd force = rows.effort.abs();
  if (force.minCoeff() < kLetGo * force.maxCoeff()) return {};
  std::vector<double> forces(force.begin(), force.end());
  const Eigen::ArrayXd least = (force <= quantile(std::move(forces), 0.25)).cast<double>();
  const double count = least.sum(), x = (least * rows.deflection).sum() / count,
               f = (least * rows.effort).sum() / count;
  const Eigen::ArrayXd dx = least * (rows.deflection - x);
  const double slope = (dx * (rows.effort - f)).sum() / std::max(dx.square().sum(), 1e-300);
  if (slope == 0.0) return {};
  return bendStarts(rows, x - f / slope, kForms);
}

constexpr ActuatorEffect kUsual = {
    .name = "spring-hardening",
    .form = "unloaded",
    .kind = ActuatorKind::kSpring,
    .cause = "the spring stiffens the more, the further it is deflected",
    .equation = "F += s e u^(n - 1), u = abs(e) / reach",
    .signature = "force over deflection bends towards the axis of force, the same way up and down",
    .remarks =
        "each side has its own s (`positive`, `negative`), the stiffness gained at the largest deflection "
        "(`reach`); n (`exponent`) is fitted",
    .source = "Treloar 1944 (rubber); 000 section IV: a shock cord is linear up to 80 % of expansion",
    .look_alikes = "spring-slack (a toe region), spring-direction",
    .separates = "slow pulls from the slack spring to the largest deflection",
    .parameters = kParameters,
    .columns = kBendColumns,
    .fill = fill,
    .starts = starts,
    .counts = bendsAboutRest,
};
constexpr ActuatorEffect kPreloaded = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "preloaded";
  effect.equation = "F += s e u^(n - 1), u = abs(e) / reach, e from where the least forces lead";
  effect.parameters = kPreloadedParameters;
  effect.starts = preloadedStarts;
  effect.counts = nullptr;
  return effect;
}();
constexpr const ActuatorEffect* kOthers[] = {&kPreloaded};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kOthers);

}  // namespace simgap::actuator_effects::spring_hardening
