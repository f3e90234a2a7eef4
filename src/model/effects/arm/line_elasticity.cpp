/// The kite line stretches under tension by a share c F of the length L_K that is not wound up. In series with the
/// cord, x = F / k + c L_K F, so that F = k x / (1 + k c L_K): softer the more line is out. (000 takes the line as
/// stiff.)
#include <algorithm>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::line_elasticity {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"compliance",
                                               "1_N",
                                               {-2e-3, 0.1, false, "a number in [-0.002, 0.1]"},
                                               0.0,
                                               2e-3,
                                               true,
                                               ArmSize::kCompliance,
                                               true}};
constexpr EffectParameters kStarts[] = {{5e-4}};
constexpr std::string_view kLookAlikes[] = {"spindle-coiling", "cord-hardening"};

CordTerm cord(const EffectParameters& p, double x, const ShockCord& cord, const LineState& state) {
  const double k = cord.stiffness;
  const double free = std::max(0.0, state.free);  // a virtual line of negative length does not stretch
  const double share = 1.0 / (1.0 + k * p[0] * free);
  return {.energy = 0.5 * k * (share - 1.0) * x * x,
          .force = k * (share - 1.0) * x,
          .stiffness = k * (share - 1.0),
          .by_stiffness = (share * share - 1.0) * x,
          .by_rest_length = 0.0,
          .by_free = state.free > 0.0 ? -k * k * p[0] * share * share * x : 0.0,
          .by_parameter = {-k * k * free * share * share * x}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "line-elasticity",
    .cause = "the kite line itself stretches under tension",
    .equation = "F = k x / (1 + k compliance L_K)",
    .signature = "a tension error in proportion to the tension and to the line that is not wound up",
    .remarks =
        "`compliance` is the line's strain per force; where all lines keep about their length it is no other "
        "thing than a softer cord",
    .target = ArmEffect::Target::kMuscleOrAll,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by = "hang a weight on the line with much and with little of it wound up: a cord stretches alike",
    .cord = cord};

}  // namespace simgap::arm_effects::line_elasticity
