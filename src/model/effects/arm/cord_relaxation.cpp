/// A shock cord goes on yielding under a steady pull and pulls harder at first: a Maxwell branch beside its spring
/// (standard linear solid), F = k x + share k (x - y), dy/dt = (x - y) / time.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::cord_relaxation {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"share", "1", {0.0, 5.0, false, "a number in [0, 5]"}, 0.0, 0.2},
                                              {"time", "s", {0.01, 1e3, false, "a number in [0.01, 1000]"}, 0.5, 0.4}};
constexpr EffectParameters kStarts[] = {{0.1, 0.2}, {0.1, 0.6}, {0.1, 2.0}, {0.3, 0.5}};
constexpr std::string_view kLookAlikes[] = {"guide-friction", "line-elasticity"};

Relaxation relaxation(const EffectParameters& p) { return {p[0], p[1]}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "cord-relaxation",
                      .cause = "the shock cord goes on yielding after it was stretched",
                      .equation = "F = k x + share k (x - y), dy/dt = (x - y) / time",
                      .signature = "a creep of the joints for some time after a step of the shafts",
                      .remarks = "k is what is left after a long time; nothing of it is seen at rest",
                      .target = ArmEffect::Target::kMuscleOrAll,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "command a step, then 2 s of rest: damping ends when the arm stands",
                      .needs_motion = true,
                      .law_sd = 0.1,
                      .relaxation = relaxation};

}  // namespace simgap::arm_effects::cord_relaxation
