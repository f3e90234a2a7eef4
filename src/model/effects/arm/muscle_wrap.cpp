/// A muscle that bends round a joint: the shortest line over a sphere of radius R about the joint's centre (000 eq. 7).
/// With the ends at distances a, b from the centre and the angle theta between them, the line touches the sphere when
/// theta > acos(R/a) + acos(R/b) and is then
///
///   L = g(a) + g(b) + R theta,    g(a) = sqrt(a^2 - R^2) - R acos(R/a),    g'(a) = sqrt(1 - R^2/a^2).
///
/// For a hinge the sphere stands for the cylinder about its axis: the same line while the ends lie in the plane of
/// turning.
#include <algorithm>
#include <cmath>

#include "simgap/model/arm/arm_effect.h"

namespace simgap::arm_effects::muscle_wrap {
namespace {

constexpr ArmEffectParameter kParameters[] = {
    {"radius", "m", {0.0, 0.5, false, "a number in [0, 0.5]"}, 0.0, 0.06, true, ArmSize::kLength, true},
    {"joint", "1", {1.0, 9.0, false, "which of the joints the line crosses, from 1"}, 1.0, 1.0, false}};
constexpr EffectParameters kStarts[] = {{0.02, 1.0},  {0.035, 1.0}, {0.055, 1.0}, {0.075, 1.0}, {0.02, 2.0},
                                        {0.035, 2.0}, {0.008, 1.0}, {0.008, 2.0}, {0.008, 3.0}, {0.008, 4.0}};
constexpr std::string_view kLookAlikes[] = {"spindle-coiling", "joint-centre-offset", "passive-joint-torque"};
constexpr double kLargest = 0.98;  // of the nearer end's distance: an end inside the sphere has no tangent

struct End {
  Eigen::Vector3d e;                                // unit vector from the centre
  Eigen::Vector3d t;                                // unit tangent towards the other end
  double distance, slope, second, slope_by_radius;  // of g
};

End end(const Eigen::Vector3d& d, double radius) {
  End end;
  end.distance = d.norm();
  end.e = d / end.distance;
  const double ratio = radius / end.distance;
  end.slope = std::sqrt(1.0 - ratio * ratio);
  end.second = ratio * ratio / (end.distance * end.slope);
  end.slope_by_radius = -ratio / (end.distance * end.slope);
  return end;
}

bool path(const EffectParameters& p, const Eigen::Vector3d& from, const Eigen::Vector3d& to, BentPath& path) {
  const double nearer = kLargest * std::min(from.norm(), to.norm());
  const bool capped = p[0] > nearer;
  const double radius = capped ? nearer : p[0];
  if (radius <= 0.0) return false;
  std::array<End, 2> ends = {end(from, radius), end(to, radius)};
  const Eigen::Vector3d normal = ends[0].e.cross(ends[1].e);
  const double sine = normal.norm();
  const double cosine = ends[0].e.dot(ends[1].e);
  const double theta = std::atan2(sine, cosine);
  const double free = std::acos(radius / ends[0].distance) + std::acos(radius / ends[1].distance);
  if (theta <= free || sine < 1e-9) return false;  // straight through the centre, no side is the shorter
  const Eigen::Vector3d m = normal / sine;
  ends[0].t = (ends[1].e - cosine * ends[0].e) / sine;
  ends[1].t = (ends[0].e - cosine * ends[1].e) / sine;
  path.radius = radius;
  path.length = radius * (theta - free);
  path.length_by_parameter = capped ? 0.0 : theta - free;
  for (int i = 0; i < 2; ++i) {
    const auto& [e, t, a, slope, second, slope_by_radius] = ends[i];
    path.length += a * slope;
    path.slope[i] = slope * e - radius / a * t;
    path.slope_by_parameter[i] = capped ? Eigen::Vector3d::Zero() : Eigen::Vector3d(slope_by_radius * e - t / a);
    const double turn = radius / (a * a);
    path.curvature[i][i] = second * e * e.transpose() + slope / a * (Eigen::Matrix3d::Identity() - e * e.transpose()) +
                           turn * (t * e.transpose() + e * t.transpose() + cosine / sine * m * m.transpose());
  }
  path.curvature[0][1] = -radius / (ends[0].distance * ends[1].distance * sine) * m * m.transpose();
  path.curvature[1][0] = path.curvature[0][1];
  return true;
}

std::string expected(const EffectParameters& p, const ArmModel& model, int target) {
  const TendonPath& line = lineOf(model, target);
  const std::vector<int> crossed = jointsCrossed(model, line);
  if (p[1] != std::floor(p[1]) || p[1] > static_cast<double>(crossed.size())) {
    return "joint to be a whole number of the " + std::to_string(crossed.size()) + " the line crosses";
  }
  const int obstacle = crossed[static_cast<std::size_t>(p[1]) - 1];
  if (model.joints[obstacle].slides()) return "a joint that turns";
  if (freeStretchOver(model, line, obstacle) < 0) return "a line with a stretch over that joint that no surface bends";
  return "";
}

}  // namespace

extern const ArmEffect entry;
const ArmEffect entry{
    .name = "muscle-wrap",
    .cause = "a muscle or ligament bends round a joint or bone instead of running straight",
    .equation = "L = sqrt(a^2 - R^2) + sqrt(b^2 - R^2) + R (theta - acos(R/a) - acos(R/b)) where it touches",
    .signature = "errors of the spanned joint on one side of an angle only, zero beyond it",
    .remarks =
        "the line touches a sphere about the centre of the joint number `joint` that it crosses (1: the first), of "
        "radius R; a and b are the distances of its ends from there, theta the angle between them; where it does not "
        "touch, the line is straight. Of a line of more points, or on an arm with slides, that is the first stretch "
        "over the joint that no surface bends, straight as soon as an end of it enters the sphere. Coiling changes its "
        "lever arm too, but follows the shaft",
    .target = ArmEffect::Target::kLine,
    .parameters = kParameters,
    .starts = kStarts,
    .look_alikes = kLookAlikes,
    .separates_by =
        "record poses on both sides of the contact: where the straight line clears the joint the wrap does nothing",
    .path = path,
    .expected = expected};

}  // namespace simgap::arm_effects::muscle_wrap
