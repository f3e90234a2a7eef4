/// A line that winds over itself winds on a growing radius: r(phi) = r (1 + g phi), so that the shaft at phi has wound
/// up r phi + r g phi^2 / 2 instead of r phi (000 eq. 12 with r kept under the integral).
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::spindle_coiling {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"growth", "1_rad", {0.0, 0.5, false, "a number in [0, 0.5]"}, 0.0, 0.15, true, ArmSize::kNone, true}};
constexpr EffectParameters kStarts[] = {{0.02}};
constexpr std::string_view kLookAlikes[] = {"cord-hardening", "muscle-wrap"};

Lengthening line(const EffectParameters& p, const LineState& s) {
  const double square = 0.5 * s.shaft * s.shaft;
  return {-s.radius * p[0] * square, -s.radius * p[0] * s.shaft, -p[0] * square, {-s.radius * square}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "spindle-coiling",
    .cause = "the kite line winds over itself, so the spindle's radius grows with the line it holds",
    .equation = "L_K = L_K0 - r (phi + growth phi^2 / 2)",
    .signature = "a tension error that grows with phi^2, whatever the force",
    .target = ArmEffect::Target::kMuscleOrAll,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "wind the muscle far with its antagonists slack, and again with them tight: coiling follows the "
        "shaft angle, a stiffening cord the force",
    .line = line};

}  // namespace simgap::arm_effects::spindle_coiling
