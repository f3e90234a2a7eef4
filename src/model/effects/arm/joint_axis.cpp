/// A hinge is mounted aslant: its axis a is turned by the rotation vector w = tilt_1 u + tilt_2 v, a' = exp(w) a, with
/// u and v the coordinate axes of the joint's frame that follow the one nearest to a (x: y and z; y: z and x; z: x and
/// y).
#include <Eigen/Geometry>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::joint_axis {
namespace {

constexpr Range kRange{-1.0, 1.0, false, "a number in [-1, 1]"};
constexpr ArmEffectParameter kParameters[] = {{"tilt_1", "rad", kRange, 0.0, 0.15},
                                              {"tilt_2", "rad", kRange, 0.0, 0.15}};
constexpr EffectParameters kStarts[] = {{0.0, 0.0}};
constexpr std::string_view kLookAlikes[] = {"marker-frame-offset", "joint-centre-offset", "gravity-tilt"};

AxisTerm tilted(const EffectParameters& p, const Eigen::Vector3d& axis) {
  Eigen::Index nearest;
  axis.cwiseAbs().maxCoeff(&nearest);
  Eigen::Matrix<double, 3, 2> basis;
  basis << Eigen::Vector3d::Unit((nearest + 1) % 3), Eigen::Vector3d::Unit((nearest + 2) % 3);
  const Eigen::Vector3d w = basis * Eigen::Vector2d(p[0], p[1]);
  const Eigen::Matrix3d turn = expSo3(w).toRotationMatrix();
  AxisTerm term;
  term.axis = turn * axis;
  // d exp(w) a / dw = -exp(w) [a]x J_r
  term.by_parameter.leftCols<2>() = -turn * cross(axis) * rightJacobian(w) * basis;
  return term;
}

std::string hingesOnly(const EffectParameters&, const ArmModel& model, int target) {
  return model.joints[target].type == JointType::kRevolute ? "" : "a hinge";
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "joint-axis",
    .cause = "a hinge's axis points another way than the model says",
    .equation = "axis' = exp(tilt_1 u + tilt_2 v) axis",
    .signature = "errors of the joints beside it that grow with the hinge's angle",
    .remarks =
        "u and v are the coordinate axes of the joint's frame that follow the one nearest to the hinge's axis (of a "
        "hinge about x: y and z); the body stays where it is at angle 0",
    .target = ArmEffect::Target::kJoint,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by = "turn the hinge by hand and find its axis from markers on both bodies",
    .hinge_axis = tilted,
    .expected = hingesOnly};

}  // namespace simgap::arm_effects::joint_axis
