/// A muscle's shaft controller has another gain than the model's.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::controller_gain {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"factor", "1", {0.02, 50.0, false, "a number in [0.02, 50]"}, 1.0, 0.3}};
constexpr EffectParameters kStarts[] = {{0.6}, {1.5}};
constexpr std::string_view kLookAlikes[] = {"command-latency", "current-limit", "torque-constant"};

void gain(const EffectParameters& p, MotorTerm& term) { term.gain *= p[0]; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "controller-gain",
                      .cause = "a muscle's controller has another gain",
                      .equation = "V = factor K_p (phi_ref - phi)",
                      .signature = "a shaft that stays farther from its set-point, or nearer to it, under load",
                      .target = ArmEffect::Target::kMuscleOrAll,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "hold a pose under load: the shaft's error times the gain is its voltage",
                      .needs_motion = true,
                      .motor = gain};

}  // namespace simgap::arm_effects::controller_gain
