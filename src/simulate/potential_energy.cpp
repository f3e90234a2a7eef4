#include "simgap/simulate/potential_energy.h"

#include <algorithm>
#include <cassert>

#include "simgap/model/kinematics.h"

namespace simgap {
namespace {

constexpr double kShortest = 1e-9;  // [m], a line without length has no direction

}  // namespace

PotentialEnergy::PotentialEnergy(const ArmModel& model) {
  joint_of_body_.assign(model.bodies.size(), -1);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    joint_of_body_[joint.child] = static_cast<int>(j);
    const int above = joint_of_body_[joint.parent];
    parent_joint_.push_back(above);
    std::vector<int>& up = up_.emplace_back();
    if (above >= 0) {
      up = up_[above];
      for (int d = 0; d < model.joints[above].degreesOfFreedom(); ++d) up.push_back(first_dof_[above] + d);
    }
    first_dof_.push_back(degreesOfFreedom());
    for (int d = 0; d < joint.degreesOfFreedom(); ++d) dofs_.push_back({static_cast<int>(j)});
  }
  links_.resize(model.joints.size());
  for (const Muscle& muscle : model.muscles) {
    Line line{{joint_of_body_[muscle.attachments[0].body], joint_of_body_[muscle.attachments[1].body]},
              static_cast<int>(levers_.size()),
              0};
    for (int end = 0; end < 2; ++end) {
      const int joint = line.joint[end];
      if (joint < 0) continue;
      std::vector<int> chain = up_[joint];
      for (int d = 0; d < model.joints[joint].degreesOfFreedom(); ++d) chain.push_back(first_dof_[joint] + d);
      for (const int dof : chain) {
        const int other = line.joint[1 - end];
        // A joint above both ends moves the muscle as a whole.
        if (other < 0 || !carries(dofs_[dof].joint, other)) levers_.push_back({dof, end});
      }
    }
    line.last = static_cast<int>(levers_.size());
    muscles_.push_back(line);
  }
  gradient_.resize(degreesOfFreedom());
  hessian_.resize(degreesOfFreedom(), degreesOfFreedom());
  setModel(model);
}

void PotentialEnergy::setModel(const ArmModel& model) {
  assert(model.muscles.size() == muscles_.size() && model.joints.size() == links_.size());
  model_ = model;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const MassProperties mass = massProperties(model.bodies[model.joints[j].child]);
    links_[j].mass = mass.mass;
    links_[j].centre_of_mass = mass.centre_of_mass;
  }
}

void PotentialEnergy::setShafts(std::span<const double> shafts) {
  assert(shafts.size() == muscles_.size());
  for (std::size_t m = 0; m < muscles_.size(); ++m) muscles_[m].shaft = shafts[m];
}

bool PotentialEnergy::carries(int joint, int other) const {
  while (other > joint) other = parent_joint_[other];
  return other == joint;
}

Eigen::Vector3d PotentialEnergy::pointInWorld(int joint, const Eigen::Vector3d& point) const {
  return joint < 0 ? point : Eigen::Vector3d(links_[joint].origin + links_[joint].rotation * point);
}

void PotentialEnergy::evaluate(std::span<const JointPosition> joints) {
  place(joints);
  energy_ = 0.0;
  gradient_.setZero();
  hessian_.setZero();
  addGravity();
  for (std::size_t m = 0; m < muscles_.size(); ++m) addMuscle(muscles_[m], model_.muscles[m]);
  for (int i = 0; i < hessian_.rows(); ++i) {
    for (int j = 0; j < i; ++j) hessian_(i, j) = hessian_(j, i);
  }
}

void PotentialEnergy::place(std::span<const JointPosition> joints) {
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Joint& joint = model_.joints[j];
    Link& link = links_[j];
    const int above = parent_joint_[j];
    link.pivot = pointInWorld(above, joint.parent_position);
    link.rotation = childInParent(joint, joints[j]);
    if (above >= 0) link.rotation = links_[above].rotation * link.rotation;
    link.origin = link.pivot - link.rotation * joint.child_position;
    if (joint.type == JointType::kSpherical) {
      for (int d = 0; d < 3; ++d) dofs_[first_dof_[j] + d].axis = link.rotation.col(d);
    } else {
      dofs_[first_dof_[j]].axis = link.rotation * joint.axis;
    }
    link.subtree_mass = link.mass;
    link.moment = link.mass * pointInWorld(static_cast<int>(j), link.centre_of_mass);
  }
  for (std::size_t j = links_.size(); j-- > 0;) {
    if (parent_joint_[j] < 0) continue;
    links_[parent_joint_[j]].subtree_mass += links_[j].subtree_mass;
    links_[parent_joint_[j]].moment += links_[j].moment;
  }
}

void PotentialEnergy::addGravity() {
  const Eigen::Vector3d& g = model_.gravity;
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Link& link = links_[j];
    if (parent_joint_[j] < 0) energy_ -= g.dot(link.moment);
    const Eigen::Vector3d arm = link.moment - link.subtree_mass * link.pivot;
    const int first = first_dof_[j];
    const int last = first + model_.joints[j].degreesOfFreedom();
    for (int k = first; k < last; ++k) {
      const Eigen::Vector3d move = dofs_[k].axis.cross(arm);
      gradient_[k] -= g.dot(move);
      for (const int i : up_[j]) hessian_(i, k) -= g.cross(dofs_[i].axis).dot(move);
      for (int i = first; i < last; ++i) {  // each unordered pair twice, with half its value
        hessian_(std::min(i, k), std::max(i, k)) -= (i == k ? 1.0 : 0.5) * g.cross(dofs_[i].axis).dot(move);
      }
    }
  }
}

void PotentialEnergy::addMuscle(Line& line, const Muscle& muscle) {
  const std::array<Eigen::Vector3d, 2> ends = {pointInWorld(line.joint[0], muscle.attachments[0].point),
                                               pointInWorld(line.joint[1], muscle.attachments[1].point)};
  const Eigen::Vector3d d = ends[1] - ends[0];
  line.length = std::max(d.norm(), kShortest);
  line.direction = d / line.length;
  const ShockCord& cord = muscle.shock_cord;
  line.expansion = line.length - muscle.kiteLineLength(line.shaft) - cord.rest_length;
  line.force = cord.stiffness * std::max(0.0, line.expansion);
  if (line.force == 0.0) return;
  energy_ += 0.5 * line.force * line.expansion;

  const double pull = line.force / line.length;
  for (int b = line.first; b < line.last; ++b) {
    Lever& lever = levers_[b];
    const Dof& dof = dofs_[lever.dof];
    const Eigen::Vector3d arm = ends[lever.end] - links_[dof.joint].pivot;
    lever.move = lever.end == 1 ? dof.axis.cross(arm) : arm.cross(dof.axis);
    lever.lever = line.direction.dot(lever.move);
    lever.turn = line.direction.cross(dof.axis);
    gradient_[lever.dof] += line.force * lever.lever;
    for (int a = line.first; a <= b; ++a) {
      const Lever& above = levers_[a];
      double h = (cord.stiffness - pull) * above.lever * lever.lever + pull * above.move.dot(lever.move);
      if (above.end == lever.end) {
        const bool same_joint = dofs_[above.dof].joint == dof.joint;
        h += line.force * (same_joint ? 0.5 * (above.turn.dot(lever.move) + lever.turn.dot(above.move))
                                      : above.turn.dot(lever.move));
      }
      hessian_(std::min(above.dof, lever.dof), std::max(above.dof, lever.dof)) += h;
    }
  }
}

}  // namespace simgap
