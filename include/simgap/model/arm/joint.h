/// \file
/// Joints of a tree of bodies. SI units.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "simgap/core/rotation.h"

namespace simgap {

/// Elastic stops of a ball: how far its axis may tilt, and how far it may twist about it (ball_stop.h).
struct BallStop {
  double swing = 1e9;                            ///< [rad], 1e9: any
  double lower_twist = -1e9, upper_twist = 1e9;  ///< [rad]
  double stiffness = 0.0;                        ///< [N m/rad]; 0: no stops
  bool operator==(const BallStop&) const = default;
};

/// Child frame in parent frame: to the joint's frame on the parent (parent_position, parent_orientation), by the
/// joint's position q, and back from the joint's frame on the child:
///
///   R = R_p Q(q) R_c^T,   x_parent = parent_position + R_p d(q) + R (x_child - child_position)
///
/// with Q the rotation of a hinge or ball and d = axis q the way of a slide.
struct Joint {
  std::string name;
  JointType type{};
  int parent = 0;                                             ///< index into bodies
  int child = 0;                                              ///< index into bodies
  Eigen::Vector3d parent_position = Eigen::Vector3d::Zero();  ///< [m] in the parent's frame
  Eigen::Vector3d child_position = Eigen::Vector3d::Zero();   ///< [m] in the child's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< in the joint's frame, unit length; of a ball that of its stops
  double lower_limit = -kUnlimited;                 ///< [rad] revolute, [m] prismatic
  double upper_limit = kUnlimited;                  ///< [rad] revolute, [m] prismatic
  double coulomb_friction = 0.0;                    ///< [N m], prismatic [N]; static = kinetic
  double viscous_friction = 0.0;                    ///< [N m s], prismatic [N s/m]
  Eigen::Quaterniond parent_orientation = Eigen::Quaterniond::Identity();  ///< R_p: joint's frame in the parent's
  Eigen::Quaterniond child_orientation = Eigen::Quaterniond::Identity();   ///< R_c: joint's frame in the child's
  double spring_stiffness = 0.0;                                           ///< [N m/rad], prismatic [N/m]; 0: none
  double spring_rest = 0.0;  ///< [rad] or [m]; a ball's rest is the identity
  int leader = -1;           ///< joint that moves this one, q = offset + ratio q_leader; -1: it moves freely
  double coupling_ratio = 1.0;
  double coupling_offset = 0.0;  ///< [rad] or [m]
  BallStop stop;                 ///< of a ball; others have limits

  static constexpr double kUnlimited = 1e9;
  bool operator==(const Joint& other) const;
  int degreesOfFreedom() const { return hasAxis() ? 1 : 3; }
  bool hasAxis() const { return type != JointType::kSpherical; }  ///< one coordinate, between limits
  bool slides() const { return type == JointType::kPrismatic; }
  bool follows() const { return leader >= 0; }
  bool elastic() const { return spring_stiffness > 0.0 || stop.stiffness > 0.0; }  ///< has an energy of its own
};

}  // namespace simgap
