/// The base is not level: gravity as the torso feels it is turned by the rotation vector (x, y, 0),
/// g' = exp([(x, y, 0)]) g. A turn about the vertical would change nothing.
#include <Eigen/Geometry>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::gravity_tilt {
namespace {

constexpr Range kRange{-1.0, 1.0, false, "a number in [-1, 1]"};
constexpr ArmEffectParameter kParameters[] = {{"about_x", "rad", kRange, 0.0, 0.2},
                                              {"about_y", "rad", kRange, 0.0, 0.2}};
constexpr EffectParameters kStarts[] = {{0.0, 0.0}};
constexpr std::string_view kLookAlikes[] = {"marker-frame-offset", "payload", "joint-axis"};

GravityTerm tilted(const EffectParameters& p, const Eigen::Vector3d& g) {
  const Eigen::Vector3d w(p[0], p[1], 0.0);
  GravityTerm term;
  term.by_gravity = expSo3(w).toRotationMatrix();
  term.gravity = term.by_gravity * g;
  // d exp(w) g / dw = exp(w) d (exp(J_r dw) g) = -exp(w) [g]x J_r
  term.by_parameter.leftCols<2>() = -(term.by_gravity * cross(g) * rightJacobian(w)).leftCols<2>();
  return term;
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "gravity-tilt",
    .cause = "the base is not level, so gravity pulls aslant",
    .equation = "g' = exp([about_x, about_y, 0]) g",
    .signature = "a torque as of a weight, in one direction of space",
    .target = ArmEffect::Target::kNone,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by = "record a few poses with all muscles slack: the arm hangs along the true vertical",
    .gravity = tilted};

}  // namespace simgap::arm_effects::gravity_tilt
