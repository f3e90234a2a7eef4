/// A motor with its gearbox at a joint (000 eq. 8-11 at rest): the current's torque, multiplied and diminished by the
/// gear, turns the joint towards larger angles. What the gearbox holds by friction is the joint's Coulomb friction.
#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::joint_motor {
namespace {

constexpr TendonParameter kParameters[] = {{"torque_constant", "Nm_A", "torque_constant_Nm_A", kPositive},
                                           {"ratio", "1", "ratio", kAnyNumber},
                                           {"efficiency", "1", "efficiency", kEfficiency},
                                           {"viscous_friction", "Nms", "viscous_friction_Nms", kNonNegative}};

TendonPull pull(const TendonParameters& p, double angle, double current) {
  const double torque = p[0] * p[1] * p[2] * current;
  return {-torque * angle,
          -torque,
          0.0,
          {-p[1] * p[2] * current, -p[0] * p[2] * current, -p[0] * p[1] * current},
          -p[0] * p[1] * p[2]};
}

double force(const TendonParameters& p, double, double rate, double current) {
  return -p[0] * p[1] * p[2] * current + p[3] * rate;
}

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "joint-motor",
                       .what = "a motor with gearbox that turns a joint",
                       .equation = "torque = torque_constant ratio efficiency i - viscous_friction dq/dt",
                       .parameters = kParameters,
                       .pull = pull,
                       .force = force,
                       .command = {"current", "A", 1.0},
                       .at_joint = true};

}  // namespace simgap::tendon_kinds::joint_motor
