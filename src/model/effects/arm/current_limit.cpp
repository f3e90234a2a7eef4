/// A motor's amplifier gives no more than a limit, whatever its controller asks for.
#include <algorithm>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::current_limit {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"limit", "A", {0.05, 1e5, false, "a number in [0.05, 1e5]"}, 1000.0, 2000.0}};
constexpr EffectParameters kStarts[] = {{3.0}, {6.0}, {1.5}};
constexpr std::string_view kLookAlikes[] = {"command-latency", "supply-sag", "controller-gain"};

void limit(const EffectParameters& p, MotorTerm& term) { term.current_limit = std::min(term.current_limit, p[0]); }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "current-limit",
                      .cause = "the amplifier limits the motor's current",
                      .equation = "|i| <= limit",
                      .signature = "large steps that are slower than the model's, small ones that are not",
                      .target = ArmEffect::Target::kMuscleOrAll,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "command small and large steps, of one motor and of many",
                      .needs_motion = true,
                      .motor = limit};

}  // namespace simgap::arm_effects::current_limit
