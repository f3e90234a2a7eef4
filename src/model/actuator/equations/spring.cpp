// F = stiffness x + offset + damping dx/dt (000 eq. 2-3), x the deflection, counted from anywhere.
#include "simgap/model/actuator/actuator_equation.h"

namespace simgap::actuator_equations::spring {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "stiffness", .unit = "Nm_rad", .lower = 0.0, .torque = false},
                                     {.name = "offset", .unit = "Nm", .torque = false},
                                     {.name = "damping", .unit = "Nms_rad", .lower = 0.0, .torque = false}};

void fill(const ActuatorRows& /*rows*/, const ActuatorTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.deflection;
  x.col(1) = 1.0;
  x.col(2) = terms.viscous;
}

}  // namespace

extern const ActuatorEquation entry;
const ActuatorEquation entry{"spring", ActuatorKind::kSpring, kColumns, fill};

}  // namespace simgap::actuator_equations::spring
