#include "simgap/model/arm/muscle_line.h"

#include <algorithm>
#include <cmath>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap {
namespace {

/// The shortest line between two points round a sphere, both as vectors from its centre: from, points on the arc, to.
std::vector<Eigen::Vector3d> bentLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
  const Eigen::Vector3d e = from.normalized();
  const Eigen::Vector3d across = (to - e * e.dot(to)).normalized();
  const double first = std::acos(radius / from.norm());
  const double last = std::atan2(across.dot(to), e.dot(to)) - std::acos(radius / to.norm());
  std::vector<Eigen::Vector3d> points{from};
  for (int k = 0; k < kArcPoints; ++k) {
    const double angle = first + (last - first) * k / (kArcPoints - 1);
    points.push_back(radius * (std::cos(angle) * e + std::sin(angle) * across));
  }
  points.push_back(to);
  return points;
}

}  // namespace

std::vector<Eigen::Vector3d> muscleLine(const ArmModel& model, std::size_t m, const std::vector<BodyInWorld>& bodies) {
  const Muscle& muscle = model.muscles[m];
  std::vector<Eigen::Vector3d> points;
  if (wrapsAsSurface(model, static_cast<int>(m))) {  // branches one after the other
    ArmModel wrapped;
    const std::vector<ArmExtension> extensions = resolveExtensions(model);
    const bool bends = std::ranges::any_of(extensions, [&](const ArmExtension& extension) {
      return extension.effect->path && extension.on(static_cast<int>(m));
    });
    if (bends) applyToModel(extensions, wrapped = model);
    const ArmModel& shaped = bends ? wrapped : model;
    for (const auto& branch : tendonPoints(shaped, shaped.muscles[m], bodies))
      points.insert(points.end(), branch.begin(), branch.end());
    return points;
  }
  for (const Attachment& a : muscle.attachments) points.push_back(bodies[a.body] * a.point);
  for (const ArmExtension& extension : resolveExtensions(model)) {
    if (extension.effect->path == nullptr || !extension.on(static_cast<int>(m))) continue;
    const auto which = static_cast<std::size_t>(extension.p[1]) - 1;
    const Joint& joint = model.joints[jointsCrossed(model, muscle)[which]];
    const Eigen::Vector3d centre = bodies[joint.child] * joint.child_position;
    BentPath bent;
    if (!extension.effect->path(extension.p, points.front() - centre, points.back() - centre, bent)) continue;
    points = bentLine(points.front() - centre, points.back() - centre, bent.radius);
    for (Eigen::Vector3d& point : points) point += centre;
    break;
  }
  return points;
}

}  // namespace simgap
