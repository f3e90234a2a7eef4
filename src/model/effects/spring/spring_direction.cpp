/// \file
/// A spring resists compression differently from tension: with e the deflection from where there is no force,
///
///     F += change min(e, 0).
#include "../deflection_sides.h"

namespace simgap::actuator_effects::spring_direction {
namespace {

constexpr EffectParameter kParameters[] = {
    {"origin", "rad", -100.0, 100.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{.name = "change", .unit = "Nm_rad", .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = (terms.deflection - p[0]).min(0.0);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return {{unloadedDeflection(rows)}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "spring-direction",
    .kind = ActuatorKind::kSpring,
    .cause = "the spring is stiffer in one direction than in the other",
    .equation = "F += change min(e, 0)",
    .signature = "a kink of the residual over deflection where there is no force",
    .remarks = "`change` is what compression (negative deflection) adds to the stiffness",
    .source = "catalogue of causes",
    .look_alikes = "spring-softening and spring-hardening of one side, spring-slack, spring-play",
    .separates = "many slow crossings of the deflection without force, with small and large amplitudes",
    .parameters = kParameters,
    .columns = kColumns,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::spring_direction
