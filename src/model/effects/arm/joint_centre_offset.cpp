/// The joint turns about another point of its parent than the model says: p' = p + (x, y, z).
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::joint_centre_offset {
namespace {

constexpr Range kRange{-0.2, 0.2, false, "a number in [-0.2, 0.2]"};
constexpr ArmEffectParameter kParameters[] = {{"x", "m", kRange, 0.0, 0.04, true, ArmSize::kLength},
                                              {"y", "m", kRange, 0.0, 0.04, true, ArmSize::kLength},
                                              {"z", "m", kRange, 0.0, 0.04, true, ArmSize::kLength}};
constexpr EffectParameters kStarts[] = {{0.0, 0.0, 0.0}};
constexpr std::string_view kLookAlikes[] = {"muscle-wrap", "joint-axis"};

Eigen::Vector3d shift(const EffectParameters& p) { return {p[0], p[1], p[2]}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{.name = "joint-centre-offset",
                      .cause = "the joint turns about another point than the model says",
                      .equation = "parent_position' = parent_position + (x, y, z)",
                      .remarks =
                          "the same as all attachments on the parent shifted the other way together, "
                          "which their hand measurements hardly allow",
                      .target = ArmEffect::Target::kJoint,
                      .parameters = kParameters,
                      .starts = kStarts,
                      .look_alikes = kLookAlikes,
                      .separates_by = "find the centre from markers while the joint is turned by hand",
                      .joint_shift = shift};

}  // namespace simgap::arm_effects::joint_centre_offset
