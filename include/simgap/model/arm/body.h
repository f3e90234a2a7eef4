/// \file
/// Rigid bodies: what they weigh, and what lines run over. SI units.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace simgap {

/// A primitive of a compound body, with its mass spread evenly (000 section III-B).
struct Part {
  enum class Shape { kSphere, kCylinder, kBox, kCapsule, kEllipsoid, kInertia };
  std::string name;
  Shape shape = Shape::kCylinder;
  double radius = 0.0;                                 ///< [m] sphere, cylinder, capsule
  double length = 0.0;                                 ///< [m] cylinder, along `axis`; capsule, without its caps
  Eigen::Vector3d size = Eigen::Vector3d::Zero();      ///< [m] box: edges; ellipsoid: semi-axes
  double mass = 0.0;                                   ///< [kg]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] centre of mass, in the body's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< cylinder, capsule: in the body's frame, unit length
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< box, ellipsoid: of its axes in the body's frame
  /// Stated inertia, about `position` along the body's axes [kg m^2]; stays as it is when the mass changes.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  bool operator==(const Part& other) const {
    return name == other.name && shape == other.shape && radius == other.radius && length == other.length &&
           size == other.size && mass == other.mass && position == other.position && axis == other.axis &&
           orientation.coeffs() == other.orientation.coeffs() && inertia == other.inertia;
  }
};

/// What lines bend over; a line touches it only where its path names it.
struct Surface {
  enum class Shape { kSphere, kCylinder };
  std::string name;
  Shape shape = Shape::kCylinder;
  double radius = 0.0;                                 ///< [m]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] of the centre, in the body's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< cylinder of any length: in the body's frame, unit length
  bool operator==(const Surface&) const = default;
};

struct Body {
  std::string name;
  bool fixed = false;  ///< its frame is the world frame
  std::vector<Part> parts;
  std::vector<Surface> surfaces;
  bool operator==(const Body&) const = default;
};

/// Mass, centre of mass and inertia of a body, in the body's frame.
struct MassProperties {
  double mass = 0.0;                                         ///< [kg]
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();         ///< [kg m^2] about the centre of mass
};

/// Sums the parts by the parallel-axis theorem.
MassProperties massProperties(const Body& body);

}  // namespace simgap
