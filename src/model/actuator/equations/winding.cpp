// V = R i + L di/dt + K_E w (000 eq. 8).
#include "simgap/model/actuator/actuator_equation.h"

namespace simgap::actuator_equations::winding {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "R", .unit = "ohm", .lower = 0.0, .torque = false},
                                     {.name = "L", .unit = "H", .lower = 0.0, .torque = false},
                                     {.name = "K_E", .unit = "Vs", .lower = 0.0, .torque = false}};

void fill(const ActuatorRows& rows, const ActuatorTerms& /*terms*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.current;
  x.col(1) = rows.current_rate;
  x.col(2) = rows.speed;
}

}  // namespace

extern const ActuatorEquation entry;
const ActuatorEquation entry{"motor", ActuatorKind::kMotor, kColumns, fill};

}  // namespace simgap::actuator_equations::winding
