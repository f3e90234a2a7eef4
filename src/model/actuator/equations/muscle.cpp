// f = p (a e^2 + b e + c), e the muscle's own contraction (002 eq. 14).
#include "simgap/model/actuator/actuator_equation.h"

namespace simgap::actuator_equations::muscle {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "a", .unit = "m2", .torque = false},
                                     {.name = "b", .unit = "m2", .torque = false},
                                     {.name = "c", .unit = "m2", .torque = false}};

void fill(const ActuatorRows& /*rows*/, const ActuatorTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.pressure * terms.contraction.square();
  x.col(1) = terms.pressure * terms.contraction;
  x.col(2) = terms.pressure;
}

}  // namespace

extern const ActuatorEquation entry;
const ActuatorEquation entry{"pam", ActuatorKind::kPam, kColumns, fill};

}  // namespace simgap::actuator_equations::muscle
