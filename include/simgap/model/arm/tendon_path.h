/// \file
/// The way of a line through space: its length, and how that changes as what it touches moves.
///
/// A path is a sum of stretches between neighbouring points, each a function of two points and perhaps of a surface
/// between them, and of wheels on joints:
///
///   L = sum_s 1/divisor_s  l_s(x_0, x_1)  +  sum_w radius_w / divisor_w  q_w
///
/// Lengths over surfaces follow MuJoCo (engine_util_misc.c, mju_wrap), so that models can be exchanged: the shortest
/// line over a sphere in the plane of its ends and the centre; over a cylinder in the plane across its axis, and along
/// the axis in proportion, a helix. Where the straight way is free, or an end lies inside, the line is straight.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {

/// A line without length has no direction: none is shorter [m].
inline constexpr double kShortestLine = 1e-9;
/// Where a drawn line lies on a surface.
inline constexpr int kArcPoints = 7;

/// Length of a line between two points and its derivatives. Those by the place of a surface follow: to move it is to
/// move both points the other way.
struct Stretch {
  double length = 0.0;                                      ///< [m]
  std::array<Eigen::Vector3d, 2> slope;                     ///< by each point, unit vectors away from the line
  std::array<std::array<Eigen::Matrix3d, 2>, 2> curvature;  ///< second derivatives
  bool wrapped = false;                                     ///< touches its surface; only then is the rest of use
  std::array<Eigen::Vector3d, 2> touch;                     ///< where it meets and leaves it
  double by_radius = 0.0;
  std::array<Eigen::Vector3d, 2> slope_by_radius;
};

/// A surface where it is now.
struct PlacedSurface {
  Surface::Shape shape;
  double radius;
  Eigen::Vector3d centre;
  Eigen::Vector3d axis;  ///< unit length
};

void straightStretch(const Eigen::Vector3d& x0, const Eigen::Vector3d& x1, Stretch& stretch);
/// \param side  a point that the line passes on the side of; null: the shorter way
void wrappedStretch(const PlacedSurface& surface, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1,
                    const Eigen::Vector3d* side, Stretch& stretch);

/// Neighbouring points of a path.
struct PathStretch {
  std::array<int, 2> station;  ///< indices into the path's list: 0 the first attachment, then what is between
  std::array<Attachment, 2> ends;
  double weight;    ///< 1 / divisor
  int over = -1;    ///< station of the surface between them, 0: an extension's; -1: straight
  int body = 0;     ///< that carries the surface; without one, the body of the first end
  int surface = 0;  ///< of that body
  bool sided = false;
  Eigen::Vector3d side = Eigen::Vector3d::Zero();  ///< in the frame of `side_body`
  int side_body = 0;
};
/// A wheel on a joint.
struct PathWheel {
  int station, joint;
  double weight, radius;
};
struct PathParts {
  std::vector<PathStretch> stretches;
  std::vector<PathWheel> wheels;
  bool empty() const { return stretches.empty() && wheels.empty(); }  ///< of a straight muscle
};
PathParts partsOf(const TendonPath& path);

/// Whether joints change its length: it runs over a wheel on one, or over two bodies.
bool jointsChange(const TendonPath& path);

/// The stretch where the bodies are now.
/// \param bodies  of the model, which have the surfaces; \param placed  shape (bodies)
void placeStretch(std::span<const Body> bodies, const PathStretch& part, std::span<const BodyInWorld> placed,
                  Stretch& stretch);

/// \param bodies  shape (bodies); \param joints  shape (joints)  \returns [m]
double tendonLength(const ArmModel& model, const TendonPath& path, std::span<const BodyInWorld> bodies,
                    std::span<const JointPosition> joints);

/// The points a line runs through [m], arcs over surfaces as polygons; a list per branch.
std::vector<std::vector<Eigen::Vector3d>> tendonPoints(const ArmModel& model, const TendonPath& path,
                                                       std::span<const BodyInWorld> bodies);

}  // namespace simgap
