#include "simgap/model/arm/arm.h"

#include <tuple>
#include <utility>

namespace simgap {
namespace {

/// diag(1/5 (b^2 + c^2), ...) m of an ellipsoid with semi-axes a, b, c; the same sum over edges of a box has 1/12.
Eigen::Matrix3d sumOfSquares(const Part& part, double factor) {
  const Eigen::Vector3d square = part.size.cwiseAbs2();
  const Eigen::Vector3d sums(square.y() + square.z(), square.z() + square.x(), square.x() + square.y());
  if (part.orientation.coeffs() == Eigen::Quaterniond::Identity().coeffs()) {
    return factor * part.mass * sums.asDiagonal().toDenseMatrix();
  }
  const Eigen::Matrix3d r = part.orientation.toRotationMatrix();
  return factor * part.mass * (r * sums.asDiagonal() * r.transpose());
}

/// Of a body of revolution about `axis`.
Eigen::Matrix3d roundInertia(double along, double across, const Eigen::Vector3d& axis) {
  return across * Eigen::Matrix3d::Identity() + (along - across) * axis * axis.transpose();
}

/// A cylinder with half spheres at both ends; their centres of mass lie 3 r / 8 beyond it.
Eigen::Matrix3d capsuleInertia(const Part& part) {
  const double r = part.radius, l = part.length;
  const double caps = part.mass * (4.0 / 3.0 * r) / (4.0 / 3.0 * r + l);
  const double tube = part.mass - caps;
  const double along = 0.5 * tube * r * r + 0.4 * caps * r * r;
  const double across = tube * (l * l / 12.0 + 0.25 * r * r) + caps * (0.4 * r * r + 0.25 * l * l + 0.375 * l * r);
  return roundInertia(along, across, part.axis);
}

/// Inertia of a part about its own centre, in the body's axes. [kg m^2]
Eigen::Matrix3d centralInertia(const Part& part) {
  switch (part.shape) {
    case Part::Shape::kSphere:
      return 0.4 * part.mass * part.radius * part.radius * Eigen::Matrix3d::Identity();
    case Part::Shape::kBox:
      return sumOfSquares(part, 1.0 / 12.0);
    case Part::Shape::kEllipsoid:
      return sumOfSquares(part, 0.2);
    case Part::Shape::kCapsule:
      return capsuleInertia(part);
    case Part::Shape::kInertia:
      return part.inertia;
    case Part::Shape::kCylinder:
      break;
  }
  const double along = 0.5 * part.mass * part.radius * part.radius;
  const double across = part.mass / 12.0 * (3.0 * part.radius * part.radius + part.length * part.length);
  return roundInertia(along, across, part.axis);
}

}  // namespace

MassProperties massProperties(const Body& body) {
  MassProperties total;
  for (const Part& part : body.parts) {
    total.mass += part.mass;
    total.centre_of_mass += part.mass * part.position;
  }
  if (total.mass <= 0.0) return total;
  total.centre_of_mass /= total.mass;
  for (const Part& part : body.parts) {
    const Eigen::Vector3d offset = part.position - total.centre_of_mass;
    total.inertia += centralInertia(part) +
                     part.mass * (offset.squaredNorm() * Eigen::Matrix3d::Identity() - offset * offset.transpose());
  }
  return total;
}

bool Joint::operator==(const Joint& other) const {
  const auto orientations = [](const Joint& j) {
    return std::pair(j.parent_orientation.coeffs(), j.child_orientation.coeffs());
  };
  const auto numbers = [](const Joint& j) {
    return std::tuple(j.name, j.type, j.parent, j.child, j.lower_limit, j.upper_limit, j.coulomb_friction,
                      j.viscous_friction, j.spring_stiffness, j.spring_rest, j.leader, j.coupling_ratio,
                      j.coupling_offset);
  };
  return numbers(*this) == numbers(other) && stop == other.stop && parent_position == other.parent_position &&
         child_position == other.child_position && axis == other.axis && orientations(*this) == orientations(other);
}

PoseLayout ArmModel::poseLayout() const {
  PoseLayout layout;
  for (const Muscle& muscle : muscles) layout.muscles.push_back(muscle.name);
  for (const PassiveTendon& tendon : tendons) {
    if (tendon.kind->command) layout.lines.push_back({tendon.commandStem(), std::string(tendon.kind->command.unit)});
  }
  for (const Joint& joint : joints) layout.joints.push_back({joint.name, joint.type});
  return layout;
}

std::size_t ArmModel::commands() const {
  const auto commanded = [](const PassiveTendon& tendon) { return static_cast<bool>(tendon.kind->command); };
  return muscles.size() + static_cast<std::size_t>(std::ranges::count_if(tendons, commanded));
}

}  // namespace simgap
