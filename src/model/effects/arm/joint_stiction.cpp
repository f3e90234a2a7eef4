/// Joint friction holds an arm short of its equilibrium, on the side it comes from: with d the way the joint would take
/// while the shafts wind, gravity and muscles still push it by tau d/|d| where it stops. It comes from the rest at
/// which every pose starts, or from the pose before.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::joint_stiction {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"torque", "Nm", {-0.5, 10.0, false, "a number in [-0.5, 10]"}, 0.0, 0.05, true, ArmSize::kTorque, true},
    {"from_previous", "1", {0.0, 1.0, false, "0 or 1"}, 0.0, 1.0, false}};
constexpr EffectParameters kStarts[] = {{0.01, 0.0}, {0.01, 1.0}};
constexpr std::string_view kLookAlikes[] = {"passive-joint-torque"};

Stiction stiction(const EffectParameters& p) { return {p[0], p[1] != 0.0}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "joint-stiction",
    .cause = "joint friction holds the arm short of its equilibrium, on the side it comes from",
    .equation = "dE/dq = -torque d/|d| at rest, d = dq/dphi (phi - phi_before)",
    .remarks =
        "it comes from rest, or from the pose before (`from_previous` 1). It is in every joint: a diagnosis counts the "
        "model's Coulomb friction as noise at first, and this names the part that has a direction. In Bullet it is the "
        "joint's Coulomb friction",
    .target = ArmEffect::Target::kJoint,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by = "approach the same command from both sides: the two positions differ by twice the lag",
    .in_every_joint = true,
    .from_previous = 1,
    .stiction = stiction};

}  // namespace simgap::arm_effects::joint_stiction
