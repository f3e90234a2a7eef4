/// \file
/// Joint positions and the distances between them, and rotations by their vectors. Quaternions are Hamilton, unit, w
/// first in files.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

namespace simgap {

enum class JointType { kSpherical, kRevolute, kPrismatic };

/// A joint of a tree by name, as measured data knows it.
struct JointChannel {
  std::string name;
  JointType type;
};

/// Position of one joint: a rotation (spherical), an angle (revolute) or a way (prismatic). Only the member of its type
/// has a meaning.
struct JointPosition {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< child frame relative to parent frame
  double angle = 0.0;                                            ///< [rad] about the joint's axis, or [m] along it
};

/// By how much the length of a quaternion in a file may differ from 1.
inline constexpr double kUnitLengthTolerance = 1e-3;

/// The turn about x, then y, then z of the frame that does not turn, as URDF has it.
/// \param rpy  angles about x, y and z [rad]
Eigen::Quaterniond fromRollPitchYaw(const Eigen::Vector3d& rpy);

/// Geodesic angle between two rotations, 2 arccos|Q . Q'|, in [0, pi] [rad]; accurate near 0 and blind to the sign of a
/// quaternion. 001 eq. (4) prints arccos(Q . Q'), which is half of it.
double geodesicAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// From one angle of a hinge to another, the shorter way, in [-pi, pi] [rad]: whole turns count as none.
double hingeTurn(double from, double to);

/// The rotation that minimises the sum of squared chordal distances (Markley et al. 2007), w >= 0.
Eigen::Quaterniond meanRotation(std::span<const Eigen::Quaterniond> rotations);

/// The shortest rotation that takes one direction to another; of opposite ones, about any axis across them.
/// \param from, to  unit length
Eigen::Quaterniond rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// \name The rotation group SO(3) by rotation vectors w (axis times angle [rad]); Sola, Deray & Atchuthan 2018.
///@{
/// The matrix [v]x, so that cross(v) w = v x w.
Eigen::Matrix3d cross(const Eigen::Vector3d& v);
/// The rotation about w by |w|; converts to a quaternion or a matrix.
Eigen::AngleAxisd expSo3(const Eigen::Vector3d& w);
/// The same as a quaternion, without the axis: for inner loops.
Eigen::Quaterniond quaternionExpSo3(const Eigen::Vector3d& w);
/// The rotation vector of a unit quaternion, |w| <= pi, whatever the quaternion's sign.
Eigen::Vector3d logSo3(const Eigen::Quaterniond& rotation);
/// J_r(w): exp(w + dw) = exp(w) exp(J_r dw) to first order.
Eigen::Matrix3d rightJacobian(const Eigen::Vector3d& w);
/// J_r(w)^-1: log(exp(w) exp(dw)) = w + J_r^-1 dw to first order, |w| < pi.
Eigen::Matrix3d inverseRightJacobian(const Eigen::Vector3d& w);
///@}

/// Radians to degrees and back.
inline constexpr double kDegree = 3.14159265358979323846 / 180.0;
inline double toDegrees(double rad) { return rad / kDegree; }

}  // namespace simgap
