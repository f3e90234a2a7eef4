/// A servo that holds the length of a line and pushes as well as it pulls: a linear actuator between two points, a rod
/// or a push-pull cable, a gear that moves several joints at once.
#include "servo.h"

namespace simgap::tendon_kinds::line_servo {
namespace {

constexpr TendonParameter kParameters[] = {{"stiffness", "N_m", "stiffness_N_m", kPositive},
                                           {"offset", "m", "offset_m", kAnyNumber},
                                           {"damping", "Ns_m", "damping_Ns_m", kNonNegative}};

}  // namespace

extern const TendonKind entry;
const TendonKind entry{.name = "line-servo",
                       .what = "a servo that holds a line's length with a stiffness of its own, pulling and pushing",
                       .equation = "F = stiffness (L - target - offset) + damping dL/dt",
                       .parameters = kParameters,
                       .pull = servoPull,
                       .force = servoForce,
                       .command = {"target", "m", 0.01}};

}  // namespace simgap::tendon_kinds::line_servo
