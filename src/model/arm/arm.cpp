#include "simgap/model/arm/arm.h"

namespace simgap {
namespace {

/// Inertia of a part about its own centre, in the body's axes. [kg m^2]
Eigen::Matrix3d centralInertia(const Part& part) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  switch (part.shape) {
    case Part::Shape::kSphere:
      return 0.4 * part.mass * part.radius * part.radius * identity;
    case Part::Shape::kBox: {
      const Eigen::Vector3d square = part.size.cwiseAbs2();
      return part.mass / 12.0 *
             Eigen::Vector3d(square.y() + square.z(), square.z() + square.x(), square.x() + square.y())
                 .asDiagonal()
                 .toDenseMatrix();
    }
    case Part::Shape::kCylinder:
      break;
  }
  const double along = 0.5 * part.mass * part.radius * part.radius;
  const double across = part.mass / 12.0 * (3.0 * part.radius * part.radius + part.length * part.length);
  return across * identity + (along - across) * part.axis * part.axis.transpose();
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

PoseLayout ArmModel::poseLayout() const {
  PoseLayout layout;
  for (const Muscle& muscle : muscles) layout.muscles.push_back(muscle.name);
  for (const Joint& joint : joints) layout.joints.push_back({joint.name, joint.type});
  return layout;
}

}  // namespace simgap
