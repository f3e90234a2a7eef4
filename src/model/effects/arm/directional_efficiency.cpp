/// A gearbox passes on another share of the torque while its load drives the motor than while the motor drives: worm
/// gears and cycloids down to none.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::directional_efficiency {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"ratio", "1", {0.1, 10.0, false, "a number in [0.1, 10]"}, 1.0, 0.3}};
constexpr EffectParameters kStarts[] = {{0.7}, {1.4}};
constexpr std::string_view kLookAlikes[] = {"torque-constant"};

void back(const EffectParameters& p, MotorTerm& term) { term.returned *= p[0]; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "directional-efficiency",
                      .cause = "the gearboxes pass on another share while the load drives the motor",
                      .equation = "eta' = ratio eta while i w < 0",
                      .signature = "currents that are off while paying out under load, and not while winding",
                      .remarks =
                          "A gear that passes on eta_b of the load's torque while it is driven has a ratio of "
                          "1 / (eta eta_b), above 1: the motor holds less than the load",
                      .target = ArmEffect::Target::kMuscleOrAll,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "wind up and pay out under the same load at the same speed",
                      .needs_motion = true,
                      .law_sd = 0.1,
                      .motor = back};

}  // namespace simgap::arm_effects::directional_efficiency
