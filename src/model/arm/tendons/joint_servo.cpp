/// A servo at a joint that holds an angle with a stiffness of its own: position control without an integral part, a
/// compliant or series-elastic drive.
#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds::joint_servo {
namespace {

constexpr TendonParameter kParameters[] = {{"stiffness", "Nm_rad", "stiffness_Nm_rad", kPositive},
                                           {"offset", "rad", "offset_rad", kAnyNumber},
                                           {"damping", "Nms", "damping_Nms", kNonNegative}};

TendonPull pull(const TendonParameters& p, double angle, double target) {
  const double off = angle - target - p[1];
  return {0.5 * p[0] * off * off, p[0] * off, p[0], {off, -p[0]}, -p[0]};
}

double force(const TendonParameters& p, double angle, double rate, double target) {
  return p[0] * (angle - target - p[1]) + p[2] * rate;
}

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "joint-servo",
                       .what = "a servo that holds a joint's angle with a stiffness of its own",
                       .equation = "torque = stiffness (target + offset - q) - damping dq/dt",
                       .parameters = kParameters,
                       .pull = pull,
                       .force = force,
                       .command = {"target", "rad", 0.5},
                       .at_joint = true};

}  // namespace simgap::tendon_kinds::joint_servo
