/// What a model's extensions add to its energy. A line that touches a joint is a function L of three points x_a, its
/// ends and the joint's centre, each carried by some joints: with r = x_a - pivot, s_a = dL/dx_a and C_ab the
/// curvature,
///
///   dL/dw_j = sum_a r_a x s_a,
///   d2L/dw_i dw_j = sum_ab (r_a x) C_ab (r_b x)^T + sum_a (r_a s_a^T - s_a.r_a 1)   (the last: i at or above j).
#include <cmath>

#include "simgap/simulate/potential_energy.h"

namespace simgap {

bool PotentialEnergy::needsHistory() const {
  for (const ArmExtension& extension : extensions_) {
    const ArmEffect& effect = *extension.effect;
    if (effect.needs_time || (effect.cord && effect.from_previous >= 0)) return true;
  }
  return false;
}

void PotentialEnergy::setHistory(double time, std::span<const double> shafts_before) {
  time_ = time;
  if (extensions_.empty()) return;
  for (std::size_t m = 0; m < model_.muscles.size(); ++m) {
    muscles_[m].before = shafts_before.empty() ? 0.0 : shafts_before[m];
  }
}

/// model_ is the model as given; afterwards what can be worked into it is.
void PotentialEnergy::prepareExtensions() {
  extensions_ = resolveExtensions(model_);
  applied_.assign(extensions_.size(), {});
  joint_terms_.assign(extensions_.size(), {});
  bends_.clear();
  for (Line& line : muscles_) {
    line.extended = false;
    line.bend = -1;
  }
  for (std::size_t e = 0; e < extensions_.size(); ++e) {
    const auto& [effect, target, p] = extensions_[e];
    if (effect->gravity) applied_[e].gravity = effect->gravity(p, model_.gravity);
    if (effect->hinge_axis) applied_[e].axis = effect->hinge_axis(p, model_.joints[target].axis);
    if (effect->mass) applied_[e].part = static_cast<int>(model_.bodies[target].parts.size());
    applyToModel({&extensions_[e], 1}, model_);
    if (effect->mass) {
      const Eigen::Vector3d& pivot = model_.joints[joint_of_body_[target]].child_position;
      applied_[e].way = (model_.bodies[target].parts.back().position - pivot).normalized();
    }
    if (effect->path && wrapsAsSurface(model_, target)) {
      applied_[e].part = pathOf(target).wrap->surface;
    } else if (effect->path) {
      const std::vector<int> crossed = jointsCrossed(model_, model_.muscles[target]);
      const int obstacle = crossed[static_cast<std::size_t>(std::lround(p[1])) - 1];
      bends_.push_back({static_cast<int>(e),
                        target,
                        obstacle,
                        {muscles_[target].joint[0], muscles_[target].joint[1], parent_joint_[obstacle]},
                        {},
                        {},
                        {},
                        std::vector<Eigen::Vector3d>(links_.size())});
    }
    if (!effect->path && !effect->line && !effect->cord) continue;
    for (int m = 0; m < muscleCount(); ++m) muscles_[m].extended |= extensions_[e].on(m);
  }
}

Lengthening PotentialEnergy::lengthening(std::size_t muscle) const {
  Lengthening sum;
  for (const ArmExtension& extension : extensions_) {
    if (!extension.effect->line || !extension.on(static_cast<int>(muscle))) continue;
    const Lengthening one = extension.effect->line(extension.p, lineState(muscle));
    sum.length += one.length;
    sum.by_shaft += one.by_shaft;
    sum.by_radius += one.by_radius;
  }
  return sum;
}

CordTerm PotentialEnergy::cordTerm(std::size_t muscle) const {
  CordTerm sum;
  for (const ArmExtension& extension : extensions_) {
    if (!extension.effect->cord || !extension.on(static_cast<int>(muscle))) continue;
    const CordTerm one = extension.effect->cord(extension.p, muscles_[muscle].expansion,
                                                model_.muscles[muscle].shock_cord, lineState(muscle));
    sum.energy += one.energy;
    sum.force += one.force;
    sum.stiffness += one.stiffness;
    sum.by_stiffness += one.by_stiffness;
    sum.by_rest_length += one.by_rest_length;
    sum.by_free += one.by_free;
  }
  return sum;
}

/// \returns whether the line touches a joint; the first one that it touches bends it
bool PotentialEnergy::bendLine(Line& line, std::size_t muscle, const std::array<Eigen::Vector3d, 2>& ends) {
  line.bend = -1;
  for (std::size_t b = 0; b < bends_.size() && line.bend < 0; ++b) {
    Bend& bend = bends_[b];
    if (bend.muscle != static_cast<int>(muscle)) continue;
    const ArmExtension& extension = extensions_[bend.extension];
    const Eigen::Vector3d& centre = links_[bend.obstacle].pivot;
    if (!extension.effect->path(extension.p, ends[0] - centre, ends[1] - centre, bend.path)) continue;
    line.bend = static_cast<int>(b);
    line.length = bend.path.length;
    bend.point = {ends[0], ends[1], centre};
    bend.slope = {bend.path.slope[0], bend.path.slope[1], -bend.path.slope[0] - bend.path.slope[1]};
    // dL/dw_j = sum_a r_a x s_a over the points that joint j carries. Moving all three together changes nothing: the
    // slopes add up to 0, likewise the rows and columns of the curvature.
    for (int j = 0; j < std::ssize(links_); ++j) {
      bend.moment[j].setZero();
      for (int a = 0; a < 3; ++a) {
        if (bend.carrier[a] < 0 || !carries(j, bend.carrier[a])) continue;
        bend.moment[j] += (bend.point[a] - links_[j].pivot).cross(bend.slope[a]);
      }
    }
  }
  return line.bend >= 0;
}

Eigen::Matrix3d PotentialEnergy::Bend::curvature(int a, int b) const {
  const auto& c = path.curvature;
  if (a < 2 && b < 2) return c[a][b];
  if (a < 2) return -c[a][0] - c[a][1];
  if (b < 2) return -c[0][b] - c[1][b];
  return c[0][0] + c[0][1] + c[1][0] + c[1][1];
}

void PotentialEnergy::addBend(const Line& line, const Bend& bend) {
  const auto carried = [&](int j, int a) { return bend.carrier[a] >= 0 && carries(j, bend.carrier[a]); };
  for (int j = 0; j < std::ssize(links_); ++j) {
    moments_[j] += line.force * bend.moment[j];
    for (int i = 0; i <= j; ++i) {
      // d2V = k dL dL + F d2L
      Eigen::Matrix3d h = line.stiffness * bend.moment[i] * bend.moment[j].transpose();
      for (int a = 0; a < 3; ++a) {
        if (!carried(i, a)) continue;
        const Eigen::Matrix3d turn = cross(bend.point[a] - links_[i].pivot);
        for (int b = 0; b < 3; ++b) {
          if (!carried(j, b)) continue;
          h -= line.force * turn * bend.curvature(a, b) * cross(bend.point[b] - links_[j].pivot);
        }
        if (!carried(j, a)) continue;
        const Eigen::Vector3d arm = bend.point[a] - links_[j].pivot;
        h += line.force * (arm * bend.slope[a].transpose() - bend.slope[a].dot(arm) * Eigen::Matrix3d::Identity());
      }
      block(i, j) += i == j ? Eigen::Matrix3d(0.5 * (h + h.transpose())) : h;
    }
  }
}

Eigen::Vector3d PotentialEnergy::bendShiftTerm(const Line& line, const Bend& bend, int joint,
                                               const Eigen::Vector3d& shift, const std::array<bool, 3>& moved,
                                               bool arm_changes) const {
  // Points b shift by s: dL = sum_b s_b.s, so d(F t) = k dL t + F (sum_a r_a x C_ab s + s x s_a).
  double longer = 0.0;
  for (int b = 0; b < 3; ++b) longer += moved[b] ? bend.slope[b].dot(shift) : 0.0;
  Eigen::Vector3d term = line.stiffness * longer * bend.moment[joint];
  for (int a = 0; a < 3; ++a) {
    if (bend.carrier[a] < 0 || !carries(joint, bend.carrier[a])) continue;
    const Eigen::Vector3d arm = bend.point[a] - links_[joint].pivot;
    for (int b = 0; b < 3; ++b) {
      if (moved[b]) term += line.force * arm.cross(bend.curvature(a, b) * shift);
    }
    if (moved[a] && arm_changes) term += line.force * shift.cross(bend.slope[a]);
  }
  return term;
}

void PotentialEnergy::addJointTerms(std::span<const JointPosition> joints) {
  for (std::size_t e = 0; e < extensions_.size(); ++e) {
    const auto& [effect, joint, p] = extensions_[e];
    if (effect->hinge_axis) positions_[joint] = joints[joint];
    if (!effect->joint_torque) continue;
    const JointTerm term = effect->joint_torque(p, model_.joints[joint].type, joints[joint]);
    const int d = first_dof_[joint];
    const int n = model_.joints[joint].degreesOfFreedom();
    energy_ += term.energy;
    gradient_.segment(d, n) += term.gradient.head(n);
    hessian_.block(d, d, n, n) += term.hessian.topLeftCorner(n, n);
    joint_terms_[e] = term;
  }
}

void PotentialEnergy::differentiateByExtension(int extension, int k, Eigen::Ref<Eigen::VectorXd> column) const {
  const auto e = static_cast<std::size_t>(extension);
  const auto& [effect, target, p] = extensions_[e];
  if (effect->gravity) {
    const Eigen::Vector3d change = applied_[e].gravity.by_parameter.col(k);
    for (int j = 0; j < std::ssize(links_); ++j) {
      addProjected(j, -liftArm(j, change), column);
    }
  }
  if (effect->joint_shift) {
    Eigen::Vector3d shift = Eigen::Vector3d::Unit(k);
    if (parent_joint_[target] >= 0) shift = links_[parent_joint_[target]].rotation.col(k);
    differentiateByJointShift(target, shift, true, column);
  }
  if (effect->hinge_axis) {
    Eigen::Vector3d change = model_.joints[target].parent_orientation * applied_[e].axis.by_parameter.col(k);
    if (parent_joint_[target] >= 0) change = (links_[parent_joint_[target]].rotation * change).eval();
    differentiateByAxis(target, change, column);
  }
  if (effect->mass) {
    const PointMass mass = effect->mass(p);
    const int joint = joint_of_body_[target];
    const Part& part = model_.bodies[target].parts[applied_[e].part];
    addWeight(joint, pointInWorld(joint, part.position), mass.mass, links_[joint].rotation * applied_[e].way,
              mass.mass_by_parameter[k], mass.distance_by_parameter[k], column);
  }
  if (effect->joint_torque) {
    const int n = model_.joints[target].degreesOfFreedom();
    column.segment(first_dof_[target], n) += joint_terms_[e].by_parameter.col(k).head(n);
  }
  if (effect->path && k == 0 && wrapsAsSurface(model_, target)) {
    differentiateBySurface({StaticParameter::Kind::kSurfaceRadius, pathOf(target).wrap->body, applied_[e].part, 0},
                           column);
    return;
  }
  if (effect->rest_shift) {
    const int rest = restLengthOf(model_.tendons[target - muscleCount()]);
    differentiateByTendon({StaticParameter::Kind::kTendonParameter, target, 0, rest}, column);
    return;
  }
  for (int m = 0; m < muscleCount(); ++m) {
    const Line& line = muscles_[m];
    if (line.force == 0.0 || !extensions_[e].on(m)) continue;
    const auto muscle = static_cast<std::size_t>(m);
    if (effect->line) addForce(muscle, -line.stiffness * effect->line(p, lineState(muscle)).by_parameter[k], column);
    if (effect->cord) {
      const CordTerm term = effect->cord(p, line.expansion, model_.muscles[m].shock_cord, lineState(muscle));
      addForce(muscle, term.by_parameter[k], column);
    }
    if (!effect->path || line.bend < 0 || k != 0) continue;
    const Bend& bend = bends_[line.bend];
    if (bend.extension != extension) continue;
    addForce(muscle, line.stiffness * bend.path.length_by_parameter, column);
    const auto& by = bend.path.slope_by_parameter;
    const std::array<Eigen::Vector3d, 3> slope = {by[0], by[1], -by[0] - by[1]};
    for (int j = 0; j < std::ssize(links_); ++j) {
      for (int a = 0; a < 3; ++a) {
        if (bend.carrier[a] < 0 || !carries(j, bend.carrier[a])) continue;
        addProjected(j, line.force * (bend.point[a] - links_[j].pivot).cross(slope[a]), column);
      }
    }
  }
}

}  // namespace simgap
