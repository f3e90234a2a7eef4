/// Commands reach the controllers late: a bus, an operating system, a planner in between. Every set-point, voltage or
/// force acts `delay` after its row says; what is measured keeps its time.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::command_latency {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"delay", "s", {0.0, 1.0, false, "a number in [0, 1]"}, 0.0, 0.04}};
constexpr EffectParameters kStarts[] = {{0.03}, {0.01}, {0.08}};
constexpr std::string_view kLookAlikes[] = {"current-limit", "supply-sag", "controller-gain"};

double delay(const EffectParameters& p) { return p[0]; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "command-latency",
                      .cause = "commands act later than their time says",
                      .equation = "phi_ref(t) = setpoint(t - delay)",
                      .signature = "shafts and joints that are late alike, in proportion to their speed",
                      .target = ArmEffect::Target::kNone,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by =
                          "command small and large steps: a latency delays both alike, a limit or a sagging supply "
                          "only the large ones",
                      .needs_motion = true,
                      .command_delay = delay};

}  // namespace simgap::arm_effects::command_latency
