/// Friction where a line runs over a guide takes a share of its tension, against the way in which it slips
/// (Euler-Eytelwein, T_out = T_in exp(-mu theta); loss = 1 - exp(-mu theta)): the body feels less than the cord pulls
/// with while the line shortens, more while it lengthens, and in between below the speed `creep`, at which a line that
/// is said to stick still gives way.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::guide_friction {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"loss", "1", {0.0, 0.9, false, "a number in [0, 0.9]"}, 0.0, 0.1},
    {"creep", "m_s", {1e-5, 1.0, false, "a number in [1e-5, 1]"}, 1e-3, 1.5e-3}};
constexpr EffectParameters kStarts[] = {{0.1, 3e-4}, {0.1, 1e-3}, {0.1, 5e-3}, {0.1, 2e-2}};
constexpr std::string_view kLookAlikes[] = {"cord-relaxation"};

GuideTerm loss(const EffectParameters& p) { return {p[0], p[1]}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "guide-friction",
    .cause = "friction where the line is guided takes a share of its tension, against its motion",
    .equation = "F_body = F (1 + loss s), s = v / sqrt(v^2 + creep^2), v = dL/dt",
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
    .law_sd = 0.1,
    .guide = loss};

}  // namespace simgap::arm_effects::guide_friction
