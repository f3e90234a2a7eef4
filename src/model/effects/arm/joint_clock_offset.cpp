/// The capture's clock and the controllers' were not started together: a frame stamped t was taken at t + offset on the
/// controllers' clock.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::joint_clock_offset {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"offset", "s", {-1.0, 1.0, false, "a number in [-1, 1]"}, 0.0, 0.05}};
constexpr EffectParameters kStarts[] = {{0.03}, {-0.03}};
constexpr std::string_view kLookAlikes[] = {"command-latency"};

double offset(const EffectParameters& p) { return p[0]; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "joint-clock-offset",
    .cause = "the capture's clock is ahead of the controllers' or behind it",
    .equation = "q_seen(t) = q(t + offset)",
    .signature = "joints that are late or early in proportion to their speed, while shafts and currents are in time",
    .remarks = "a calibration on motions finds a small one by itself: its last parameter",
    .target = ArmEffect::Target::kNone,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "record one movement at two speeds: an offset is the same time at both, friction in the joints is not",
    .needs_motion = true,
    .frame_delay = offset};

}  // namespace simgap::arm_effects::joint_clock_offset
