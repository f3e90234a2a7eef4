/// \file
/// Equations of motion of a tree of joints that begins at fixed bodies:
///
///     M(q) dv/dt + h(q, v) = tau
///
/// v holds a joint's velocity along its own axes, which turn with the child: three turns of a spherical joint, one of a
/// revolute one, one way of a prismatic one. M by composite bodies, h (Coriolis, centrifugal, gravity) by recursive
/// Newton-Euler, both in the world's frame (Featherstone 2008, chapters 5 and 6).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "bullet_joint.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {

/// Memory is taken in setArm() only.
class ArmDynamics {
 public:
  /// \param links  shape (bodies): the frame along whose axes spherical joints count
  void setArm(const std::vector<Body>& bodies, const std::vector<Joint>& joints, const std::vector<BulletLink>& links);
  /// Takes places of all bodies, and sums M. \param frames  shape (bodies)
  void place(std::span<const BodyInWorld> frames);

  int degreesOfFreedom() const { return dofs_; }
  const Eigen::MatrixXd& massMatrix() const { return mass_; }
  /// h(q, v). \param v  shape (dof)  \param[out] torque  shape (dof) [N m]
  void bias(const Eigen::VectorXd& v, const Eigen::Vector3d& gravity, Eigen::VectorXd& torque);
  /// Adds dp/dq . slope of a point p that a body carries. \param[in,out] row  shape (dof)
  void addSlope(int body, const Eigen::Vector3d& point, const Eigen::Vector3d& slope, Eigen::VectorXd& row) const;
  int firstDof(std::size_t joint) const { return links_[joint].first; }
  /// Adds a torque between a joint's two bodies, on its child, to tau. It turns: no prismatic joint.
  void addJointTorque(std::size_t joint, const Eigen::Vector3d& torque_in_world, Eigen::VectorXd& tau) const;
  /// -sum m g . x [J]
  double gravityEnergy(const Eigen::Vector3d& gravity) const;

 private:
  struct Link {  ///< the child of a joint; in the world but for what is said to be the body's
    int body, parent_body;
    int parent;  ///< joint that carries the joint's parent, -1: fixed
    int first, size;
    bool slides;  ///< along its only axis
    double mass;
    Eigen::Vector3d pivot_in_body, centre_in_body;
    Eigen::Matrix3d axes_in_body, inertia_in_body;
    Eigen::Vector3d pivot, centre;
    Eigen::Matrix3d axes, inertia;  ///< columns; about the centre of mass
    double composite_mass;          ///< of the link and all that hangs on it
    Eigen::Vector3d composite_centre;
    Eigen::Matrix3d composite_inertia;
    Eigen::Vector3d spin, spin_rate, pivot_acceleration;
    Eigen::Vector3d force, moment;  ///< that the joint passes on, about its pivot
  };

  int dofs_ = 0;
  std::vector<Link> links_;         ///< shape (joints)
  std::vector<int> joint_of_body_;  ///< shape (bodies), -1: fixed
  Eigen::MatrixXd mass_;
};

}  // namespace simgap
