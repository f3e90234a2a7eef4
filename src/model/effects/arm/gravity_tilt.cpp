/// The base is not level: gravity as the torso feels it is turned by the rotation vector (x, y, 0),
/// g' = exp([(x, y, 0)]) g. A turn about the vertical would change nothing.
#include <Eigen/Geometry>
#include <cmath>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects {
namespace {

constexpr Range kRange{-1.0, 1.0, false, "a number in [-1, 1]"};
constexpr ArmEffectParameter kParameters[] = {{"about_x", "rad", kRange, 0.0, 0.2},
                                              {"about_y", "rad", kRange, 0.0, 0.2}};
constexpr EffectParameters kStarts[] = {{0.0, 0.0}};
constexpr std::string_view kLookAlikes[] = {"marker-frame-offset", "payload"};

GravityTerm tilted(const EffectParameters& p, const Eigen::Vector3d& g) {
  const Eigen::Vector3d w(p[0], p[1], 0.0);
  const double angle = w.norm();
  // Rodrigues: g cos + sinc (w x g) + versc w (w.g)
  const double sinc = angle > 1e-4 ? std::sin(angle) / angle : 1.0 - angle * angle / 6.0;
  const double versc = angle > 1e-4 ? (1.0 - std::cos(angle)) / (angle * angle) : 0.5 - angle * angle / 24.0;
  GravityTerm term;
  term.by_gravity << 0.0, 0.0, w.y(), 0.0, 0.0, -w.x(), -w.y(), w.x(), 0.0;  // w x
  term.by_gravity = std::cos(angle) * Eigen::Matrix3d::Identity() + sinc * term.by_gravity + versc * w * w.transpose();
  term.gravity = term.by_gravity * g;
  // d sinc / d angle over angle, likewise versc
  const double d_sinc = angle > 1e-2 ? (std::cos(angle) - sinc) / (angle * angle) : -1.0 / 3.0 + angle * angle / 30.0;
  const double d_versc = angle > 1e-2 ? (sinc - 2.0 * versc) / (angle * angle) : -1.0 / 12.0 + angle * angle / 180.0;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(i);
    term.by_parameter.col(i) = -sinc * w[i] * g + d_sinc * w[i] * w.cross(g) + sinc * e.cross(g) +
                               d_versc * w[i] * w.dot(g) * w + versc * (e.dot(g) * w + w.dot(g) * e);
  }
  return term;
}

}  // namespace

extern const ArmEffect gravity_tilt;
const ArmEffect gravity_tilt{
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

}  // namespace simgap::arm_effects
