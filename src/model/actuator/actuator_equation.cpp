#include "simgap/model/actuator/actuator_equation.h"

namespace simgap::actuator_equations {
namespace {

constexpr EffectColumn kWinding[] = {{.name = "R", .unit = "ohm", .lower = 0.0, .torque = false},
                                     {.name = "L", .unit = "H", .lower = 0.0, .torque = false},
                                     {.name = "K_E", .unit = "Vs", .lower = 0.0, .torque = false}};

void fillWinding(const ActuatorRows& rows, const ActuatorTerms& /*terms*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.current;
  x.col(1) = rows.current_rate;
  x.col(2) = rows.speed;
}

constexpr EffectColumn kPam[] = {{.name = "a", .unit = "m2", .torque = false},
                                 {.name = "b", .unit = "m2", .torque = false},
                                 {.name = "c", .unit = "m2", .torque = false}};

void fillMuscle(const ActuatorRows& /*rows*/, const ActuatorTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.pressure * terms.contraction.square();
  x.col(1) = terms.pressure * terms.contraction;
  x.col(2) = terms.pressure;
}

constexpr EffectColumn kSpring[] = {{.name = "stiffness", .unit = "Nm_rad", .lower = 0.0, .torque = false},
                                    {.name = "offset", .unit = "Nm", .torque = false},
                                    {.name = "damping", .unit = "Nms_rad", .lower = 0.0, .torque = false}};

void fillSpring(const ActuatorRows& /*rows*/, const ActuatorTerms& terms, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.deflection;
  x.col(1) = 1.0;
  x.col(2) = terms.viscous;
}

constexpr EffectColumn kTransmission[] = {{.name = "inverse_ratio", .unit = "1", .torque = false},
                                          {.name = "offset", .unit = "rad", .torque = false},
                                          {.name = "lag", .unit = "s", .torque = false}};

void fillTransmission(const ActuatorRows& rows, const ActuatorTerms& /*terms*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.motor_angle;
  x.col(1) = 1.0;
  x.col(2) = -rows.speed;
}

}  // namespace

const ActuatorEquation winding = {"motor", ActuatorKind::kMotor, kWinding, fillWinding};
const ActuatorEquation muscle = {"pam", ActuatorKind::kPam, kPam, fillMuscle};
const ActuatorEquation spring = {"spring", ActuatorKind::kSpring, kSpring, fillSpring};
const ActuatorEquation transmission = {"transmission", ActuatorKind::kTransmission, kTransmission, fillTransmission};

}  // namespace simgap::actuator_equations
