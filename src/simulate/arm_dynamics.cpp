#include "arm_dynamics.h"

namespace simgap {
namespace {

/// Of a point mass at x from where it is taken: m (x.x 1 - x x^T).
Eigen::Matrix3d pointInertia(double mass, const Eigen::Vector3d& x) {
  return mass * (x.squaredNorm() * Eigen::Matrix3d::Identity() - x * x.transpose());
}

}  // namespace

void ArmDynamics::setArm(const std::vector<Body>& bodies, const std::vector<Joint>& joints,
                         const std::vector<BulletLink>& links) {
  dofs_ = 0;
  links_ = std::vector<Link>(joints.size());
  joint_of_body_.assign(bodies.size(), -1);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const MassProperties mass = massProperties(bodies[joint.child]);
    Link& link = links_[j];
    link.body = joint.child;
    link.parent_body = joint.parent;
    link.parent = joint_of_body_[joint.parent];
    link.first = dofs_;
    link.size = joint.degreesOfFreedom();
    link.slides = joint.slides();
    link.mass = mass.mass;
    link.pivot_in_body = joint.child_position;
    link.centre_in_body = mass.centre_of_mass;
    link.axes_in_body.setZero();
    if (!joint.hasAxis()) {
      link.axes_in_body = links[joint.child].body_from_link.toRotationMatrix();
    } else {
      link.axes_in_body.col(0) = joint.child_orientation * joint.axis;
    }
    link.inertia_in_body = mass.inertia;
    joint_of_body_[joint.child] = static_cast<int>(j);
    dofs_ += link.size;
  }
  mass_ = Eigen::MatrixXd::Zero(dofs_, dofs_);
}

void ArmDynamics::place(std::span<const BodyInWorld> frames) {
  for (Link& link : links_) {
    const BodyInWorld& frame = frames[link.body];
    link.pivot = frame * link.pivot_in_body;
    link.centre = frame * link.centre_in_body;
    link.axes = frame.rotation * link.axes_in_body;
    link.inertia = frame.rotation * link.inertia_in_body * frame.rotation.transpose();
    link.composite_mass = link.mass;
    link.composite_centre = link.mass * link.centre;  // the sum first, divided when complete
    link.composite_inertia = link.inertia + pointInertia(link.mass, link.centre);
  }
  for (auto link = links_.rbegin(); link != links_.rend(); ++link) {
    if (link->parent >= 0) {
      Link& parent = links_[link->parent];
      parent.composite_mass += link->composite_mass;
      parent.composite_centre += link->composite_centre;
      parent.composite_inertia += link->composite_inertia;
    }
    link->composite_centre /= link->composite_mass;
    link->composite_inertia -= pointInertia(link->composite_mass, link->composite_centre);

    // Momentum of all that hangs on the joint, per unit velocity about each of its axes, seen by the axes above it.
    for (int k = 0; k < link->size; ++k) {
      const Eigen::Vector3d axis = link->axes.col(k);
      const Eigen::Vector3d way = link->slides ? axis : axis.cross(link->composite_centre - link->pivot);
      const Eigen::Vector3d momentum = link->composite_mass * way;
      const Eigen::Vector3d spin =
          link->slides ? Eigen::Vector3d(0.0, 0.0, 0.0) : Eigen::Vector3d(link->composite_inertia * axis);
      for (const Link* above = &*link;; above = &links_[above->parent]) {
        const Eigen::Vector3d moment = spin + (link->composite_centre - above->pivot).cross(momentum);
        for (int i = 0; i < above->size; ++i) {
          mass_(above->first + i, link->first + k) = mass_(link->first + k, above->first + i) =
              above->axes.col(i).dot(above->slides ? momentum : moment);
        }
        if (above->parent < 0) break;
      }
    }
  }
}

void ArmDynamics::bias(const Eigen::VectorXd& v, const Eigen::Vector3d& gravity, Eigen::VectorXd& torque) {
  for (Link& link : links_) {
    Eigen::Vector3d relative = Eigen::Vector3d::Zero(), slide = Eigen::Vector3d::Zero();
    for (int k = 0; k < link.size; ++k) (link.slides ? slide : relative) += v[link.first + k] * link.axes.col(k);
    if (link.parent >= 0) {
      const Link& parent = links_[link.parent];
      const Eigen::Vector3d way = link.pivot - parent.pivot;
      link.spin = parent.spin + relative;
      link.spin_rate = parent.spin_rate + parent.spin.cross(relative);  // the axes turn with the child
      link.pivot_acceleration = parent.pivot_acceleration + parent.spin_rate.cross(way) +
                                parent.spin.cross(parent.spin.cross(way) + 2.0 * slide);
    } else {
      link.spin = relative;
      link.spin_rate.setZero();
      link.pivot_acceleration = -gravity;
    }
    const Eigen::Vector3d to_centre = link.centre - link.pivot;
    link.force = link.mass * (link.pivot_acceleration + link.spin_rate.cross(to_centre) +
                              link.spin.cross(link.spin.cross(to_centre)));
    link.moment =
        link.inertia * link.spin_rate + link.spin.cross(link.inertia * link.spin) + to_centre.cross(link.force);
  }
  for (auto link = links_.rbegin(); link != links_.rend(); ++link) {
    for (int k = 0; k < link->size; ++k) {
      torque[link->first + k] = link->axes.col(k).dot(link->slides ? link->force : link->moment);
    }
    if (link->parent < 0) continue;
    Link& parent = links_[link->parent];
    parent.force += link->force;
    parent.moment += link->moment + (link->pivot - parent.pivot).cross(link->force);
  }
}

void ArmDynamics::addSlope(int body, const Eigen::Vector3d& point, const Eigen::Vector3d& slope,
                           Eigen::VectorXd& row) const {
  for (int j = joint_of_body_[body]; j >= 0; j = links_[j].parent) {
    const Eigen::Vector3d moment = links_[j].slides ? slope : Eigen::Vector3d((point - links_[j].pivot).cross(slope));
    for (int k = 0; k < links_[j].size; ++k) row[links_[j].first + k] += links_[j].axes.col(k).dot(moment);
  }
}

void ArmDynamics::addJointTorque(std::size_t joint, const Eigen::Vector3d& torque_in_world,
                                 Eigen::VectorXd& tau) const {
  const Link& link = links_[joint];
  for (int k = 0; k < link.size; ++k) tau[link.first + k] += link.axes.col(k).dot(torque_in_world);
}

double ArmDynamics::gravityEnergy(const Eigen::Vector3d& gravity) const {
  double energy = 0.0;
  for (const Link& link : links_) energy -= link.mass * gravity.dot(link.centre);
  return energy;
}

}  // namespace simgap
