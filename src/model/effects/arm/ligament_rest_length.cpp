/// A ligament that is longer or shorter than the file says by more than its measurement allows: L_R + offset. It was
/// overstretched, or is fixed at another place. The rest length itself may be a parameter of the fit, too; then this
/// names the ligament for which that does not suffice.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::ligament_rest_length {
namespace {

// How well a ligament is tied does not depend on how large the arm is.
constexpr ArmEffectParameter kParameters[] = {
    {"offset", "m", {-0.5, 0.5, false, "a number in [-0.5, 0.5]"}, 0.0, 0.01}};
constexpr EffectParameters kStarts[] = {{0.002}, {-0.002}};
constexpr std::string_view kLookAlikes[] = {"passive-joint-torque", "muscle-wrap"};

double restShift(const EffectParameters& p) { return p[0]; }

std::string expected(const EffectParameters& p, const ArmModel& model, int target) {
  const PassiveTendon& tendon = model.tendons[target - static_cast<int>(model.muscles.size())];
  const int rest = restLengthOf(tendon);
  if (rest < 0) return "a tendon with a rest length";
  const Range& range = tendon.kind->parameters[rest].range;
  const double shifted = tendon.p[rest] + p[0];
  return shifted > range.lower ? "" : "an offset that leaves a rest length above 0";
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "ligament-rest-length",
    .cause = "a ligament or spring is longer or shorter than it was measured",
    .equation = "L_R -> L_R + offset",
    .signature = "errors of the joints it spans on the side where it is taut",
    .target = ArmEffect::Target::kTendon,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by = "slacken all muscles and note where the joint begins to resist: there the ligament becomes taut",
    .rest_shift = restShift,
    .expected = expected};

}  // namespace simgap::arm_effects::ligament_rest_length
