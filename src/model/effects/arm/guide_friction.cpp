/// Friction where a line runs over a guide takes a share of its tension, against the way in which it slips
/// (Euler-Eytelwein, T_out = T_in exp(-mu theta); loss = 1 - exp(-mu theta)): the body feels less than the cord pulls
/// with while the line shortens, more while it lengthens, and anything between while it stands.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::guide_friction {
namespace {

constexpr ArmEffectParameter kParameters[] = {{"loss", "1", {0.0, 0.9, false, "a number in [0, 0.9]"}, 0.0, 0.1}};
constexpr EffectParameters kStarts[] = {{0.05}, {0.2}};
constexpr std::string_view kLookAlikes[] = {"cord-relaxation"};

double loss(const EffectParameters& p) { return p[0]; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "guide-friction",
    .cause = "friction where the line is guided takes a share of its tension, against its motion",
    .equation = "F_body = F (1 + loss s), s = sign(dL/dt), between -1 and 1 at rest",
    .signature = "joints held back in proportion to the tension of the muscles, whichever way they turn",
    .remarks = "pulley-friction is what rests show of it",
    .target = ArmEffect::Target::kMuscleOrAll,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "record the same movement at two co-contractions: friction of guides grows with the tension, friction of the "
        "joints does not",
    .needs_motion = true,
    .guide_loss = loss};

}  // namespace simgap::arm_effects::guide_friction
