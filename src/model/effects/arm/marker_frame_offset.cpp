/// The frame that the capture gives a body is turned against its bone by the rotation vector w, in the body's frame:
/// R_captured = R exp(w). Joints are captured as R_parent^-1 q R_child.
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::marker_frame_offset {
namespace {

constexpr Range kRange{-1.5, 1.5, false, "a number in [-1.5, 1.5]"};
constexpr ArmEffectParameter kParameters[] = {
    {"about_x", "rad", kRange, 0.0, 0.2}, {"about_y", "rad", kRange, 0.0, 0.2}, {"about_z", "rad", kRange, 0.0, 0.2}};
constexpr EffectParameters kStarts[] = {{0.0, 0.0, 0.0}};
constexpr std::string_view kLookAlikes[] = {"gravity-tilt", "joint-axis"};

Eigen::Vector3d turn(const EffectParameters& p) { return {p[0], p[1], p[2]}; }

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "marker-frame-offset",
    .cause = "the markers' frame is turned against the bone that carries it",
    .equation = "R_captured = R exp([about_x, about_y, about_z])",
    .remarks = "a turn of the last body shows only about its hinge",
    .target = ArmEffect::Target::kBody,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "calibrate the joints' axes anew from slow movements by hand: they give the bone's frame without muscles",
    .marker_turn = turn};

}  // namespace simgap::arm_effects::marker_frame_offset
