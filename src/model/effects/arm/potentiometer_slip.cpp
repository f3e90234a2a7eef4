/// A potentiometer that slipped on its shaft reads the spindle wrong from one moment on: the line is wound by
/// r (phi + a) for t >= t*, though the record says phi.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::potentiometer_slip {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"angle", "rad", {-10.0, 10.0, false, "a number in [-10, 10]"}, 0.0, 1.5},
                                              {"time", "s", kAnyNumber, 0.0, 1.0, false}};
constexpr EffectParameters kStarts[] = {{0.1, 0.0}};
constexpr std::string_view kLookAlikes[] = {"cord-creep", "potentiometer-slip"};

Lengthening line(const EffectParameters& p, const LineState& s) {
  if (!(s.time >= p[1])) return {};
  return {-s.radius * p[0], 0.0, -p[0], {-s.radius, 0.0}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "potentiometer-slip",
    .cause = "the potentiometer slipped on its shaft at one moment",
    .equation = "L_K = L_K0 - r (phi + angle) from the moment time on",
    .signature = "a step in the order of recording",
    .target = ArmEffect::Target::kMuscle,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "unwind the muscle until its line hangs slack and read the potentiometer: only the slipped one differs "
        "from before",
    .needs_time = true,
    .from_moment = true,
    .line = line};

}  // namespace simgap::arm_effects::potentiometer_slip
