// theta = theta_M / r + offset - lag w_M: a rigid transmission whose two encoders are not read at the same moment.
#include "simgap/model/actuator/actuator_equation.h"

namespace simgap::actuator_equations::transmission {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "inverse_ratio", .unit = "1", .torque = false},
                                     {.name = "offset", .unit = "rad", .torque = false},
                                     {.name = "lag", .unit = "s", .torque = false}};

void fill(const ActuatorRows& rows, const ActuatorTerms& /*terms*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.motor_angle;
  x.col(1) = 1.0;
  x.col(2) = -rows.speed;
}

}  // namespace

extern const ActuatorEquation entry;
const ActuatorEquation entry{"transmission", ActuatorKind::kTransmission, kColumns, fill};

}  // namespace simgap::actuator_equations::transmission
