/// \file
/// A spring gives way the more, the further it is deflected: with e the deflection from where there is no force,
///
///     F -= s e u^(n - 1) / (1 - c + c u),   u = |e| / reach,   s >= 0 on either side of its own.
///
/// s is the stiffness (force over deflection) that is lost at the largest deflection of the log.
#include "../deflection_sides.h"

namespace simgap::actuator_effects::spring_softening {
namespace {

constexpr EffectParameter kParameters[] = {{"exponent", "1", 1.0, 10.0, 2.0, 2.0, EffectParameter::Kind::kConstant},
                                           {"saturation", "1", 0.0, 0.8, 0.0, 0.0, EffectParameter::Kind::kShape},
                                           kBendOrigin,
                                           kReach};
constexpr BendForm kForms[] = {{2.0, 0.0}, {2.0, 0.5}, {2.0, 0.75}, {3.0, 0.0}};

void fill(std::span<const double> p, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  fillBend(p, terms.deflection, -1.0, x);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return bendStarts(rows, unloadedDeflection(rows), kForms);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-softening",
    .kind = ActuatorKind::kSpring,
    .cause = "the spring gives way the more, the further it is deflected",
    .equation = "F -= s e u^(n - 1) / (1 - c + c u), u = abs(e) / reach",
    .signature = "force over deflection bends towards the deflection's axis, the same way up and down",
    .remarks =
        "each side has its own s (`positive`, `negative`), the stiffness lost at the largest deflection (`reach`); "
        "the data choose a square or a cube (n, `exponent`); how soon the bend levels off (c, `saturation`) is fitted",
    .source = "Treloar 1944 (rubber)",
    .look_alikes = "spring-hysteresis when only one amplitude was recorded, spring-direction",
    .separates = "slow loops of several amplitudes, from small ones to the largest, in both directions",
    .parameters = kParameters,
    .columns = kBendColumns,
    .fill = fill,
    .starts = starts,
    .counts = bendsAboutRest,
};

}  // namespace simgap::actuator_effects::spring_softening
