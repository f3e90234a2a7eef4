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
  return bendStarts(rows, kForms);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-hardening",
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

}  // namespace simgap::actuator_effects::spring_hardening
