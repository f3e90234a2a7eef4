/// All motors hang on one supply whose voltage falls with what they draw, U = U_0 - R I, buffered by capacitors. A
/// controller's voltage is a duty cycle of it.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::supply_sag {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"resistance", "ohm", {0.0, 10.0, false, "a number in [0, 10]"}, 0.0, 0.2},
    {"time", "s", {5e-4, 10.0, false, "a number in [0.0005, 10]"}, 0.005, 0.005}};
constexpr EffectParameters kStarts[] = {{0.05, 0.005}, {0.2, 0.005}};
constexpr std::string_view kLookAlikes[] = {"command-latency", "current-limit"};

SupplyTerm supply(const EffectParameters& p) { return {p[0], p[1]}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "supply-sag",
                      .cause = "the supply's voltage falls while the motors draw current",
                      .equation = "V' = V U / U_0, time dU/dt = U_0 - resistance sum V' i / U - U",
                      .signature = "large steps of many motors at once that are slower than the model's",
                      .target = ArmEffect::Target::kNone,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "command the same large step of one motor and of all: a limit is each motor's",
                      .needs_motion = true,
                      .supply = supply};

}  // namespace simgap::arm_effects::supply_sag
