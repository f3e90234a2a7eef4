/// A muscle's motor gives another torque per ampere: hot magnets, a swapped motor, a sensor that misreads the current.
/// Its back-EMF constant is the same number by physics and changes with it.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::torque_constant {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"factor", "1", {0.1, 10.0, false, "a number in [0.1, 10]"}, 1.0, 0.15}};
constexpr EffectParameters kStarts[] = {{0.85}, {1.15}};
constexpr std::string_view kLookAlikes[] = {"directional-efficiency", "controller-gain"};

void change(const EffectParameters& p, int target, ArmModel& model) {
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    if (target >= 0 && m != static_cast<std::size_t>(target)) continue;
    model.muscles[m].motor.torque_constant *= p[0];
    model.muscles[m].motor.back_emf_constant *= p[0];
  }
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "torque-constant",
                      .cause = "a muscle's motor gives another torque per ampere",
                      .equation = "K_T' = factor K_T, K_E' = factor K_E",
                      .signature = "a current that is off in proportion to the load, of one muscle",
                      .target = ArmEffect::Target::kMuscle,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "wind up and pay out under the same load: an efficiency differs between them",
                      .needs_motion = true,
                      .change = change};

}  // namespace simgap::arm_effects::torque_constant
