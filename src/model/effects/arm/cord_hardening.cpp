/// Shock cord stiffens beyond its linear range (000 eq. 2-3 hold to 80 %): F = k x (1 + h (x / L_SR)^2), so that
/// U = 1/2 k x^2 (1 + h/2 (x / L_SR)^2).
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::cord_hardening {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"hardening", "1", {-0.3, 20.0, false, "a number in [-0.3, 20]"}, 0.0, 2.0}};
constexpr EffectParameters kStarts[] = {{0.1}};
constexpr std::string_view kLookAlikes[] = {"spindle-coiling"};

CordTerm cord(const EffectParameters& p, double x, const ShockCord& cord, const LineState&) {
  const double k = cord.stiffness;
  const double square = x * x / (cord.rest_length * cord.rest_length);  // of the strain
  return {.energy = 0.25 * k * p[0] * square * x * x,
          .force = k * p[0] * square * x,
          .stiffness = 3.0 * k * p[0] * square,
          .by_stiffness = p[0] * square * x,
          .by_rest_length = -2.0 * k * p[0] * square * x / cord.rest_length,
          .by_parameter = {k * square * x}};
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "cord-hardening",
    .cause = "the shock cord stiffens as it is stretched far",
    .equation = "F = k x (1 + hardening (x / L_SR)^2)",
    .signature = "a tension error that grows with the third power of the expansion",
    .target = ArmEffect::Target::kMuscleOrAll,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "hold one shaft and pull the cord by the antagonist alone: a hardening cord resists ever more, coiling "
        "does not change",
    .cord = cord};

}  // namespace simgap::arm_effects::cord_hardening
