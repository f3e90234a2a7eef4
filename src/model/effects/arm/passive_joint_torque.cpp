/// Skin, cables or an elastic stop push a joint back: a spring in its angle q, 1/2 k u^2 with
///
///   u = q - q0 (side 0),   max(0, q - q0) (side 1: a stop above q0),   max(0, q0 - q) (side -1: below).
///
/// A spherical joint's angle is the whole rotation from identity, and only side 1 has a meaning there. With r the
/// rotation vector and f(|r|) the energy, the gradient in the child's frame is f' r/|r| and the Hessian
/// f'' e e^T + f'/2 cot(|r|/2) (1 - e e^T).
#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::passive_joint_torque {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"stiffness", "Nm_rad", {-50.0, 500.0, false, "a number in [-50, 500]"}, 0.0, 1.0, true, ArmSize::kTorque},
    {"rest_angle", "rad", {-3.2, 3.2, false, "a number in [-3.2, 3.2]"}, 0.5, 0.7},
    {"side", "1", {-1.0, 1.0, false, "-1, 0 or 1"}, 0.0, 1.0, false}};
constexpr EffectParameters kStarts[] = {{0.05, 0.3, 0.0}, {0.1, 0.7, 1.0},  {0.3, 1.3, 1.0},
                                        {0.1, 1.2, -1.0}, {0.3, 0.6, -1.0}, {0.05, 0.0, 1.0}};
constexpr std::string_view kLookAlikes[] = {"muscle-wrap", "payload"};

/// Stretch of the spring and its derivative by the joint's angle.
struct Stretch {
  double u, slope;
};
Stretch stretch(const EffectParameters& p, double angle) {
  const double u = angle - p[1];
  if (p[2] == 0.0) return {u, 1.0};
  if (p[2] > 0.0) return {std::max(0.0, u), u > 0.0 ? 1.0 : 0.0};
  return {std::min(0.0, u), u < 0.0 ? 1.0 : 0.0};
}

JointTerm torque(const EffectParameters& p, JointType type, const JointPosition& position) {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  double angle = position.angle;
  double bend = 0.0;  // half cotangent of half the angle
  if (!kindOf(type).has_axis) {
    const Eigen::Quaterniond& q = position.rotation;
    const double sine = q.vec().norm();
    angle = 2.0 * std::atan2(sine, std::abs(q.w()));
    if (angle < 1e-9) return {};  // no direction; a spring from identity has no torque there
    axis = (q.w() < 0.0 ? -1.0 : 1.0) / sine * q.vec();
    bend = 0.5 / std::tan(0.5 * angle);
  }
  const auto [u, slope] = stretch(p, angle);
  JointTerm term;
  term.energy = 0.5 * p[0] * u * u;
  term.gradient = p[0] * u * axis;
  const Eigen::Matrix3d along = axis * axis.transpose();
  term.hessian = (p[0] * slope) * along + (p[0] * u * bend) * (Eigen::Matrix3d::Identity() - along);
  term.by_parameter.col(0) = u * axis;
  term.by_parameter.col(1) = -p[0] * slope * axis;
  return term;
}

std::string expected(const EffectParameters& p, const ArmModel& model, int target) {
  if (model.joints[target].slides()) return "a joint that turns";
  if (!model.joints[target].hasAxis() && p[2] != 1.0) return "side 1 for a spherical joint";
  return p[2] == 0.0 || std::abs(p[2]) == 1.0 ? "" : "side -1, 0 or 1";
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "passive-joint-torque",
    .cause = "skin, cables or an elastic stop push the joint back",
    .equation = "tau = -stiffness (q - rest_angle), on one side of it or on both",
    .remarks =
        "the spring acts on both sides of `rest_angle` (`side` 0), above it (1) or below (-1). For a spherical joint "
        "the angle is the whole rotation from identity and `side` is 1",
    .target = ArmEffect::Target::kJoint,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "slacken all muscles and turn the joint by hand with a spring balance: what still pushes back is passive",
    .joint_torque = torque,
    .expected = expected};

}  // namespace simgap::arm_effects::passive_joint_torque
