/// A servo at a joint that holds an angle with a stiffness of its own: position control without an integral part, a
/// compliant or series-elastic drive.
#include "servo.h"

namespace simgap::tendon_kinds::joint_servo {
namespace {

constexpr TendonParameter kParameters[] = {{"stiffness", "Nm_rad", "stiffness_Nm_rad", kPositive},
                                           {"offset", "rad", "offset_rad", kAnyNumber},
                                           {"damping", "Nms", "damping_Nms", kNonNegative}};

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "joint-servo",
                       .what = "a servo that holds a joint's angle with a stiffness of its own",
                       .equation = "torque = stiffness (target + offset - q) - damping dq/dt",
                       .parameters = kParameters,
                       .pull = servoPull,
                       .force = servoForce,
                       .command = {"target", "rad", 0.5},
                       .at_joint = true};

}  // namespace simgap::tendon_kinds::joint_servo
