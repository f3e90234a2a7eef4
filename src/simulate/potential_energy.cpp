/// Energy, gradient and Hessian by rotations w_j of everything below joint j, about its pivot c_j, in the world. A
/// point x below both i and j (i at or above j) moves by
///
///   dx/dw_j . e = e x (x - c_j),      d2x/dw_i dw_j . (e, f) = e x (f x (x - c_j)),
///
/// which makes an energy that falls along a force p at x have, with r = x - c_j,
///
///   dV/dw_j = -r x p,      d2V/dw_i dw_j = (p.r) 1 - r p^T.
///
/// The rotations of one joint do not commute: its own block is the symmetric part (a second-order step about one axis).
#include "simgap/simulate/potential_energy.h"

#include <algorithm>
#include <cassert>
#include <functional>

#include "simgap/model/arm/kinematics.h"

namespace simgap {
PotentialEnergy::PotentialEnergy(const ArmModel& model) {
  joint_of_body_.assign(model.bodies.size(), -1);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    joint_of_body_[joint.child] = static_cast<int>(j);
    parent_joint_.push_back(joint_of_body_[joint.parent]);
    first_dof_.push_back(dofs_);
    dofs_ += joint.degreesOfFreedom();
  }
  links_.resize(model.joints.size());
  for (const Muscle& muscle : model.muscles) {
    Line line{{joint_of_body_[muscle.attachments[0].body], joint_of_body_[muscle.attachments[1].body]},
              static_cast<int>(levers_.size()),
              0};
    for (int end = 0; end < 2; ++end) {
      const int other = line.joint[1 - end];
      const auto begin = std::ssize(levers_);
      for (int joint = line.joint[end]; joint >= 0; joint = parent_joint_[joint]) {
        // A joint above both ends moves the muscle as a whole.
        if (other < 0 || !carries(joint, other)) levers_.push_back({joint, end});
      }
      std::reverse(levers_.begin() + begin, levers_.end());
    }
    line.last = static_cast<int>(levers_.size());
    muscles_.push_back(line);
  }
  muscles_.resize(model.muscles.size() + model.tendons.size());
  model_ = model;
  applyToModel(resolveExtensions(model), model_);
  for (int m = 0; m < std::ssize(muscles_); ++m) {
    const Line& line = muscles_[m];
    const bool slides = std::any_of(levers_.begin() + line.first, levers_.begin() + line.last,
                                    [&](const Lever& lever) { return model.joints[lever.joint].slides(); });
    if (m >= muscleCount() || !model.muscles[m].straight() || slides || pathOf(m).wrap) makePath(m);
  }
  axes_.resize(3, dofs_);
  positions_.resize(links_.size());
  moments_.resize(links_.size());
  blocks_.resize(links_.size() * links_.size());
  gradient_.resize(dofs_);
  hessian_.resize(dofs_, dofs_);
  setModel(model);
}

void PotentialEnergy::setModel(const ArmModel& model) {
  assert(model.muscles.size() + model.tendons.size() == muscles_.size() && model.joints.size() == links_.size());
  model_ = model;
  if (!model.extensions.empty() || !extensions_.empty()) prepareExtensions();
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const MassProperties mass = massProperties(model_.bodies[model_.joints[j].child]);
    links_[j].mass = mass.mass;
    links_[j].centre_of_mass = mass.centre_of_mass;
    const Joint& joint = model_.joints[j];
    links_[j].turned = joint.child_orientation.coeffs() != Eigen::Quaterniond::Identity().coeffs();
    links_[j].axis_in_child = joint.child_orientation * joint.axis;
  }
  springs_ = std::any_of(model_.joints.begin(), model_.joints.end(), std::mem_fn(&Joint::elastic));
  for (LongPath& path : paths_) refreshPath(path);
}

void PotentialEnergy::setShafts(std::span<const double> shafts) {
  assert(shafts.size() == model_.commands());
  const std::size_t muscles = model_.muscles.size();
  for (std::size_t m = 0; m < muscles; ++m) muscles_[m].shaft = shafts[m];
  std::size_t next = muscles;
  for (std::size_t t = 0; next < shafts.size(); ++t) {
    if (model_.tendons[t].kind->command) muscles_[muscles + t].shaft = shafts[next++];
  }
}

bool PotentialEnergy::carries(int joint, int other) const {
  while (other > joint) other = parent_joint_[other];
  return other == joint;
}

void PotentialEnergy::evaluate(std::span<const JointPosition> joints) {
  place(joints);
  energy_ = 0.0;
  for (Eigen::Vector3d& moment : moments_) moment.setZero();
  for (Eigen::Matrix3d& block : blocks_) block.setZero();
  addGravity();
  for (std::size_t m = 0; m < model_.muscles.size(); ++m) {
    if (muscles_[m].path < 0) addMuscle(m);
  }
  project();
  if (!paths_.empty()) placeAxes();
  for (LongPath& path : paths_) addPath(path, joints);
  if (!paths_.empty()) {  // the same to the last bit on both sides
    hessian_.triangularView<Eigen::StrictlyLower>() = hessian_.transpose().triangularView<Eigen::StrictlyLower>();
  }
  if (springs_) addJointSprings(joints);
  if (!extensions_.empty()) addJointTerms(joints);
}

void PotentialEnergy::place(std::span<const JointPosition> joints) {
  // Down the tree: c_j and R_j, and of each body alone its mass and first moment m x.
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Joint& joint = model_.joints[j];
    Link& link = links_[j];
    const int above = parent_joint_[j];
    link.pivot = pointInWorld(above, joint.parent_position);
    if (joint.slides()) link.pivot = pointInWorld(above, pivotInParent(joint, joints[j]));
    link.rotation = childInParent(joint, joints[j]);
    if (above >= 0) link.rotation = links_[above].rotation * link.rotation;
    link.origin = link.pivot - link.rotation * joint.child_position;
    link.axis = link.rotation * link.axis_in_child;
    if (link.turned) link.basis = link.rotation * joint.child_orientation.toRotationMatrix();
    link.subtree_mass = link.mass;
    link.moment = link.mass * pointInWorld(static_cast<int>(j), link.centre_of_mass);
  }
  // Up again: each joint carries the masses and moments of all below it.
  for (std::size_t j = links_.size(); j-- > 0;) {
    if (parent_joint_[j] < 0) continue;
    links_[parent_joint_[j]].subtree_mass += links_[j].subtree_mass;
    links_[parent_joint_[j]].moment += links_[j].moment;
  }
}

void PotentialEnergy::addGravity() {
  const Eigen::Vector3d& g = model_.gravity;
  for (int j = 0; j < std::ssize(links_); ++j) {
    const Link& link = links_[j];
    if (parent_joint_[j] < 0) energy_ -= g.dot(link.moment);
    if (model_.joints[j].slides()) {
      // All masses below shift by v: dV/dv = -m g; under a joint that turns, d2V/dw_i dv = m [g]x.
      moments_[j] -= link.subtree_mass * g;
      for (int i = parent_joint_[j]; i >= 0; i = parent_joint_[i]) {
        if (!model_.joints[i].slides()) block(i, j) += link.subtree_mass * cross(g);
      }
      continue;
    }
    // The force m g on all masses below j: sum m (x - c_j) takes the place of r.
    const Eigen::Vector3d arm = link.moment - link.subtree_mass * link.pivot;
    moments_[j] -= arm.cross(g);
    const Eigen::Matrix3d second = g.dot(arm) * Eigen::Matrix3d::Identity() - arm * g.transpose();
    block(j, j) += 0.5 * (second + second.transpose());
    for (int i = parent_joint_[j]; i >= 0; i = parent_joint_[i]) {
      if (!model_.joints[i].slides()) block(i, j) += second;
    }
  }
}

void PotentialEnergy::setForce(std::size_t m) {
  Line& line = muscles_[m];
  const Muscle& muscle = model_.muscles[m];
  const ShockCord& cord = muscle.shock_cord;
  // x = L - L_K(phi) - dL(phi) - L_SR, V = k x^2 / 2 while taut, F = dV/dx, and dF/dx; then what effects add to each.
  line.expansion = line.length - muscle.kiteLineLength(line.shaft) - cord.rest_length;
  if (line.extended) line.expansion -= lengthening(m).length;
  line.force = cord.stiffness * std::max(0.0, line.expansion);
  line.stiffness = cord.stiffness;
  energy_ += 0.5 * line.force * line.expansion;
  if (!line.extended || line.expansion <= 0.0) return;
  const CordTerm term = cordTerm(m);
  energy_ += term.energy;
  line.force += term.force;
  line.stiffness += term.stiffness;
}

void PotentialEnergy::addMuscle(std::size_t m) {
  Line& line = muscles_[m];
  const Muscle& muscle = model_.muscles[m];
  const std::array<Eigen::Vector3d, 2> ends = {pointInWorld(line.joint[0], muscle.attachments[0].point),
                                               pointInWorld(line.joint[1], muscle.attachments[1].point)};
  if (line.extended && bendLine(line, m, ends)) {
    setForce(m);
    if (line.force != 0.0) addBend(line, bends_[line.bend]);
    return;
  }
  // L = |d|, u = d / L.
  const Eigen::Vector3d d = ends[1] - ends[0];
  line.length = std::max(d.norm(), kShortestLine);
  line.direction = d / line.length;
  setForce(m);
  if (line.force == 0.0) return;

  const Eigen::Vector3d& u = line.direction;
  const double pull = line.force / line.length;
  for (int b = line.first; b < line.last; ++b) {
    Lever& lever = levers_[b];
    // dV/dw = F dL/dw with dL/dw = u . dd/dw = +-r x u, + for joints that carry end 1.
    lever.arm = ends[lever.end] - links_[lever.joint].pivot;
    const double sign = lever.end == 1 ? 1.0 : -1.0;
    lever.moment = sign * lever.arm.cross(u);
    moments_[lever.joint] += line.force * lever.moment;
    const double turning = sign * line.force * u.dot(lever.arm);
    for (int a = line.first; a <= b; ++a) {
      const Lever& above = levers_[a];
      // d2V = k dL dL + F d2L, and L d2L = dd.dd + d.d2d - dL dL: together (k - F/L) dL dL + F/L dd.dd + F u.d2d,
      // where dd_i.dd_j = +-((r_i.r_j) 1 - r_j r_i^T), and d2d = 0 between joints that carry different ends.
      Eigen::Matrix3d h = (line.stiffness - pull) * above.moment * lever.moment.transpose();
      const double same = above.end == lever.end ? pull : -pull;
      h.noalias() -= same * lever.arm * above.arm.transpose();
      h.diagonal().array() += same * above.arm.dot(lever.arm);
      if (a == b) {
        const Eigen::Matrix3d turn = (0.5 * sign * line.force) * lever.arm * u.transpose();
        h += turn + turn.transpose();
        h.diagonal().array() -= turning;
      } else if (above.end == lever.end) {
        h.noalias() += (sign * line.force) * lever.arm * u.transpose();
        h.diagonal().array() -= turning;
      }
      if (above.joint <= lever.joint) {
        block(above.joint, lever.joint) += h;
      } else {
        block(lever.joint, above.joint) += h.transpose();
      }
    }
  }
}

/// Gradient and Hessian of the degrees of freedom from those of the joints' rotations in the world: w_j = R_j q_j for a
/// ball, w_j = a_j q_j for a hinge or a slide with axis a_j.
void PotentialEnergy::project() {
  const auto basis = [](const Link& link) -> const Eigen::Matrix3d& {
    return link.turned ? link.basis : link.rotation;
  };
  for (int j = 0; j < std::ssize(links_); ++j) {
    const bool ball = !model_.joints[j].hasAxis();
    const int d = first_dof_[j];
    if (ball) {
      gradient_.segment<3>(d) = basis(links_[j]).transpose() * moments_[j];
    } else {
      gradient_[d] = links_[j].axis.dot(moments_[j]);
    }
    for (int i = 0; i <= j; ++i) {
      const bool upper_ball = !model_.joints[i].hasAxis();
      const int c = first_dof_[i];
      if (ball) {
        const Eigen::Matrix3d columns = block(i, j) * basis(links_[j]);
        if (upper_ball) {
          hessian_.block<3, 3>(c, d) = basis(links_[i]).transpose() * columns;
        } else {
          hessian_.block<1, 3>(c, d) = links_[i].axis.transpose() * columns;
        }
      } else {
        const Eigen::Vector3d column = block(i, j) * links_[j].axis;
        if (upper_ball) {
          hessian_.block<3, 1>(c, d) = basis(links_[i]).transpose() * column;
        } else {
          hessian_(c, d) = links_[i].axis.dot(column);
        }
      }
    }
  }
  for (int i = 0; i < dofs_; ++i) {
    for (int j = 0; j < i; ++j) hessian_(i, j) = hessian_(j, i);
  }
}

Eigen::MatrixXd couplingsOf(const PotentialEnergy& energy) {
  const std::vector<Joint>& joints = energy.model().joints;
  if (std::ranges::none_of(joints, &Joint::follows)) return {};
  const int n = energy.degreesOfFreedom();
  Eigen::MatrixXd moves = Eigen::MatrixXd::Identity(n, n);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!joints[j].follows()) continue;
    const int d = energy.firstDof(static_cast<int>(j));
    moves(d, d) = 0.0;
    moves(d, energy.firstDof(joints[j].leader)) = joints[j].coupling_ratio;
  }
  return moves;
}

}  // namespace simgap
