/// Lines of more than two points, springs of joints: by degree of freedom.
///
/// A stretch's length l(y_0, y_1) is a function of its points as seen from its frame S, y = S^-1 x. A degree of freedom
/// that turns about w moves y by c = +-w x (x - pivot) (a slide: +-w), + where it carries the point alone, - where it
/// carries the frame alone; one that carries both does nothing. Of two that move the same point, the one nearer to it
/// in the chain from the point to the frame acts first, and the other turns what that does:
///
///   d2y/dq_inner dq_outer = +-w_outer x c_inner,
///   d2l/dq_k dq_l = sum_ab c_ak^T C_ab c_bl + sum_a s_a . d2y_a.
#include <algorithm>
#include <cmath>

#include "simgap/model/arm/ball_stop.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

const TendonPath& PotentialEnergy::pathOf(int line) const {
  if (line < muscleCount()) return model_.muscles[line];
  return model_.tendons[line - muscleCount()];
}

/// From the point up to where the frame's way to the ground begins, then down to the frame.
std::vector<PotentialEnergy::Mover> PotentialEnergy::moversBetween(int carrier, int frame) const {
  std::vector<Mover> movers;
  const auto add = [&](int joint, double sign) {
    for (int d = 0; d < model_.joints[joint].degreesOfFreedom(); ++d) {
      movers.push_back({first_dof_[joint] + d, joint, sign});
    }
  };
  for (int j = carrier; j >= 0; j = parent_joint_[j]) {
    if (frame < 0 || !carries(j, frame)) add(j, 1.0);
  }
  std::vector<int> below;
  for (int j = frame; j >= 0; j = parent_joint_[j]) {
    if (carrier < 0 || !carries(j, carrier)) below.push_back(j);
  }
  for (auto j = below.rbegin(); j != below.rend(); ++j) add(*j, -1.0);
  return movers;
}

void PotentialEnergy::makePath(int line) {
  LongPath path;
  path.line = line;
  const PathParts parts = partsOf(pathOf(line));
  path.wheels = parts.wheels;
  path.by_dof.setZero(dofs_);
  for (const PathStretch& part : parts.stretches) {
    PlacedStretch stretch;
    stretch.part = part;
    stretch.frame = joint_of_body_[part.body];
    for (int a = 0; a < 2; ++a) {
      stretch.carrier[a] = joint_of_body_[part.ends[a].body];
      stretch.movers[a] = moversBetween(stretch.carrier[a], stretch.frame);
      stretch.columns[a].resize(3, std::ssize(stretch.movers[a]));
      for (const Mover& mover : stretch.movers[a]) path.dofs.push_back(mover.dof);
    }
    path.stretches.push_back(std::move(stretch));
  }
  for (const PathWheel& wheel : path.wheels) path.dofs.push_back(first_dof_[wheel.joint]);
  std::sort(path.dofs.begin(), path.dofs.end());
  path.dofs.erase(std::unique(path.dofs.begin(), path.dofs.end()), path.dofs.end());
  muscles_[line].path = static_cast<int>(paths_.size());
  paths_.push_back(std::move(path));
}

/// Takes over the numbers of model_.
void PotentialEnergy::refreshPath(LongPath& path) {
  const TendonPath& from = pathOf(path.line);
  const auto station = [&](int k) -> const Attachment& {
    if (k == 0) return from.attachments[0];
    return k > std::ssize(from.between) ? from.attachments[1] : from.between[static_cast<std::size_t>(k) - 1].at;
  };
  for (PlacedStretch& stretch : path.stretches) {
    PathStretch& part = stretch.part;
    for (int a = 0; a < 2; ++a) part.ends[a].point = station(part.station[a]).point;
    if (part.sided) part.side = station(part.over).point;
  }
  for (PathWheel& wheel : path.wheels) wheel.radius = from.between[static_cast<std::size_t>(wheel.station) - 1].radius;
}

void PotentialEnergy::placeAxes() {
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const int d = first_dof_[j];
    if (model_.joints[j].hasAxis()) {
      axes_.col(d) = links_[j].axis;
    } else {
      axes_.middleCols<3>(d) = links_[j].turned ? links_[j].basis : links_[j].rotation;
    }
  }
}

Eigen::Vector3d PotentialEnergy::wayBy(const Mover& mover, const Eigen::Vector3d& from_pivot) const {
  const Eigen::Vector3d axis = mover.sign * axes_.col(mover.dof);
  return model_.joints[mover.joint].slides() ? axis : axis.cross(from_pivot);
}

void PotentialEnergy::placePath(LongPath& path, std::span<const JointPosition> joints) {
  Line& line = muscles_[path.line];
  line.length = 0.0;
  path.by_dof.setZero();
  for (PlacedStretch& stretch : path.stretches) {
    const PathStretch& part = stretch.part;
    std::array<Eigen::Vector3d, 2> point;
    for (int a = 0; a < 2; ++a) point[a] = pointInWorld(stretch.carrier[a], part.ends[a].point);
    if (part.over < 0) {
      straightStretch(point[0], point[1], stretch.now);
    } else {
      const Surface& surface = model_.bodies[part.body].surfaces[part.surface];
      Eigen::Vector3d axis = surface.axis;
      if (stretch.frame >= 0) axis = links_[stretch.frame].rotation * surface.axis;
      const Eigen::Vector3d side = pointInWorld(joint_of_body_[part.side_body], part.side);
      wrappedStretch({surface.shape, surface.radius, pointInWorld(stretch.frame, surface.position), axis}, point[0],
                     point[1], part.sided ? &side : nullptr, stretch.now);
    }
    line.length += part.weight * stretch.now.length;
    for (int a = 0; a < 2; ++a) {
      for (Eigen::Index k = 0; k < std::ssize(stretch.movers[a]); ++k) {
        const Mover& mover = stretch.movers[a][k];
        stretch.columns[a].col(k) = wayBy(mover, point[a] - links_[mover.joint].pivot);
        path.by_dof[mover.dof] += part.weight * stretch.now.slope[a].dot(stretch.columns[a].col(k));
      }
    }
  }
  for (const PathWheel& wheel : path.wheels) {
    positions_[wheel.joint] = joints[wheel.joint];
    line.length += wheel.weight * wheel.radius * joints[wheel.joint].angle;
    path.by_dof[first_dof_[wheel.joint]] += wheel.weight * wheel.radius;
  }
}

void PotentialEnergy::addPath(LongPath& path, std::span<const JointPosition> joints) {
  placePath(path, joints);
  Line& line = muscles_[path.line];
  if (path.line < muscleCount()) {
    setForce(static_cast<std::size_t>(path.line));
    path.slack = line.force == 0.0;
  } else {
    const PassiveTendon& tendon = model_.tendons[path.line - muscleCount()];
    const TendonPull pull = tendon.kind->pull(tendon.p, line.length, line.shaft);
    energy_ += pull.energy;
    line.force = pull.force;
    line.stiffness = pull.stiffness;
    line.by_command = pull.by_command;
    path.slack = pull.force == 0.0 && pull.stiffness == 0.0;
  }
  if (path.slack) return;
  // d2V = k dL dL + F d2L
  for (const int d : path.dofs) {
    gradient_[d] += line.force * path.by_dof[d];
    for (const int e : path.dofs) hessian_(d, e) += line.stiffness * path.by_dof[d] * path.by_dof[e];
  }
  for (const PlacedStretch& stretch : path.stretches) addCurvature(stretch, line.force * stretch.part.weight);
}

void PotentialEnergy::addCurvature(const PlacedStretch& stretch, double force) {
  for (int a = 0; a < 2; ++a) {
    const std::vector<Mover>& movers = stretch.movers[a];
    for (Eigen::Index k = 0; k < std::ssize(movers); ++k) {
      for (int b = 0; b < 2; ++b) {
        const Eigen::Vector3d bent = force * (stretch.now.curvature[b][a] * stretch.columns[a].col(k));
        for (Eigen::Index l = 0; l < std::ssize(stretch.movers[b]); ++l) {
          hessian_(stretch.movers[b][l].dof, movers[k].dof) += stretch.columns[b].col(l).dot(bent);
        }
      }
      // What a mover does is turned by itself and by those behind it; of one ball's axes each turns the other by half.
      for (Eigen::Index l = 0; l < std::ssize(movers); ++l) {
        const bool same = movers[l].joint == movers[k].joint;
        if ((l < k && !same) || model_.joints[movers[l].joint].slides()) continue;
        const Eigen::Vector3d outer = movers[l].sign * axes_.col(movers[l].dof);
        const double term = force * stretch.now.slope[a].dot(outer.cross(stretch.columns[a].col(k)));
        const double share = same ? 0.5 : 1.0;
        hessian_(movers[k].dof, movers[l].dof) += share * term;
        hessian_(movers[l].dof, movers[k].dof) += share * term;
      }
    }
  }
}

void PotentialEnergy::addJointSprings(std::span<const JointPosition> joints) {
  for (std::size_t j = 0; j < links_.size(); ++j) {
    const Joint& joint = model_.joints[j];
    const double stiffness = joint.spring_stiffness;
    if (!joint.elastic()) continue;
    positions_[j] = joints[j];
    const int d = first_dof_[j];
    if (joint.stop.stiffness > 0.0) {
      const JointTerm stop = ballStop(joint.stop, joint.axis, joints[j].rotation);
      energy_ += stop.energy;
      gradient_.segment<3>(d) += stop.gradient;
      hessian_.block<3, 3>(d, d) += stop.hessian;
    }
    if (stiffness <= 0.0) continue;
    if (joint.hasAxis()) {
      const double stretch = joints[j].angle - joint.spring_rest;
      energy_ += 0.5 * stiffness * stretch * stretch;
      gradient_[d] += stiffness * stretch;
      hessian_(d, d) += stiffness;
      continue;
    }
    // V = k |w|^2 / 2 with w = log Q; dw = J_r^-1 of a turn in the child's frame, and J_r^-T w = w.
    const Eigen::Vector3d turn = logSo3(joints[j].rotation);
    const Eigen::Matrix3d slope = inverseRightJacobian(turn);
    energy_ += 0.5 * stiffness * turn.squaredNorm();
    gradient_.segment<3>(d) += stiffness * turn;
    hessian_.block<3, 3>(d, d) += 0.5 * stiffness * (slope + slope.transpose());
  }
}

void PotentialEnergy::momentArms(std::size_t line, Eigen::Ref<Eigen::VectorXd> moment_arms) const {
  moment_arms.setZero();
  const Line& of = muscles_[line];
  if (of.path >= 0 || of.bend >= 0) return addForce(line, 1.0, moment_arms);
  for (int b = of.first; b < of.last; ++b) {  // of a slack line evaluate() works out none
    const Lever& lever = levers_[b];
    const Eigen::Vector3d end = pointInWorld(of.joint[lever.end], model_.muscles[line].attachments[lever.end].point);
    const double sign = lever.end == 1 ? 1.0 : -1.0;
    addProjected(lever.joint, sign * (end - links_[lever.joint].pivot).cross(of.direction), moment_arms);
  }
}

template <class PivotShift>
void PotentialEnergy::addStretchShift(const LongPath& path, const PlacedStretch& stretch,
                                      const std::array<Eigen::Vector3d, 2>& points, const Eigen::Vector3d& frame,
                                      const PivotShift& pivot, Eigen::Ref<Eigen::VectorXd> column) const {
  const Line& line = muscles_[path.line];
  const double weight = stretch.part.weight;
  const std::array<Eigen::Vector3d, 2> seen = {points[0] - frame, points[1] - frame};
  const auto& [slope, curvature] = std::tie(stretch.now.slope, stretch.now.curvature);
  // d(F dL/dq_k) = k dL dL/dq_k + F (sum_b c_k^T C_ab dy_b + s_a . dc_k),   dc_k = +-w_k x (shift of point - of pivot)
  column += line.stiffness * weight * (slope[0].dot(seen[0]) + slope[1].dot(seen[1])) * path.by_dof;
  for (int a = 0; a < 2; ++a) {
    const Eigen::Vector3d turned = curvature[a][0] * seen[0] + curvature[a][1] * seen[1];
    for (Eigen::Index k = 0; k < std::ssize(stretch.movers[a]); ++k) {
      const Mover& mover = stretch.movers[a][k];
      double term = stretch.columns[a].col(k).dot(turned);
      if (!model_.joints[mover.joint].slides()) {
        term += slope[a].dot(wayBy(mover, points[a] - pivot(mover.joint)));
      }
      column[mover.dof] += line.force * weight * term;
    }
  }
}

void PotentialEnergy::differentiatePathByStation(const LongPath& path, const StaticParameter& p,
                                                 Eigen::Ref<Eigen::VectorXd> column) const {
  if (path.slack) return;
  const Line& line = muscles_[path.line];
  for (const PathWheel& wheel : path.wheels) {
    if (wheel.station != p.part || p.kind != StaticParameter::Kind::kWheelRadius) continue;
    column += line.stiffness * wheel.weight * positions_[wheel.joint].angle * path.by_dof;
    column[first_dof_[wheel.joint]] += line.force * wheel.weight;
  }
  if (p.kind == StaticParameter::Kind::kWheelRadius) return;
  const auto still = [](int) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); };
  for (const PlacedStretch& stretch : path.stretches) {
    for (int a = 0; a < 2; ++a) {
      if (stretch.part.station[a] != p.part) continue;
      Eigen::Vector3d shift = Eigen::Vector3d::Unit(p.component);
      if (stretch.carrier[a] >= 0) shift = links_[stretch.carrier[a]].rotation.col(p.component);
      std::array<Eigen::Vector3d, 2> points = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      points[a] = shift;
      addStretchShift(path, stretch, points, Eigen::Vector3d::Zero(), still, column);
    }
  }
}

void PotentialEnergy::differentiatePathByJointShift(const LongPath& path, int joint, const Eigen::Vector3d& shift,
                                                    bool pivot_moves, Eigen::Ref<Eigen::VectorXd> column) const {
  if (path.slack) return;
  const auto below = [&](int other) -> Eigen::Vector3d {
    return other >= 0 && carries(joint, other) ? shift : Eigen::Vector3d::Zero();
  };
  const auto pivot = [&](int other) -> Eigen::Vector3d {
    return other == joint && !pivot_moves ? Eigen::Vector3d::Zero() : below(other);
  };
  for (const PlacedStretch& stretch : path.stretches) {
    addStretchShift(path, stretch, {below(stretch.carrier[0]), below(stretch.carrier[1])}, below(stretch.frame), pivot,
                    column);
  }
}

/// As if one more degree of freedom of the joint, about the turn, moved the points.
void PotentialEnergy::differentiatePathByAxis(const LongPath& path, int joint, const Eigen::Vector3d& change,
                                              const Eigen::Vector3d& turn, Eigen::Ref<Eigen::VectorXd> column) const {
  if (path.slack) return;
  const Line& line = muscles_[path.line];
  const Link& hinge = links_[joint];
  for (const PlacedStretch& stretch : path.stretches) {
    const double force = line.force * stretch.part.weight;
    for (int a = 0; a < 2; ++a) {
      const std::vector<Mover>& movers = stretch.movers[a];
      const auto own = std::ranges::find(movers, joint, &Mover::joint);
      if (own == movers.end()) continue;
      const Eigen::Vector3d& slope = stretch.now.slope[a];
      const Eigen::Vector3d arm = pointInWorld(stretch.carrier[a], stretch.part.ends[a].point) - hinge.pivot;
      const Eigen::Vector3d outer = own->sign * turn;
      const Eigen::Vector3d way = outer.cross(arm);
      column += line.stiffness * stretch.part.weight * slope.dot(way) * path.by_dof;
      for (int b = 0; b < 2; ++b) {
        const Eigen::Vector3d bent = force * (stretch.now.curvature[b][a] * way);
        for (Eigen::Index l = 0; l < std::ssize(stretch.movers[b]); ++l) {
          column[stretch.movers[b][l].dof] += stretch.columns[b].col(l).dot(bent);
        }
      }
      // The turn's way is turned by the movers behind it, and it turns those before it; of its own joint's each by
      // half.
      for (Eigen::Index l = 0; l < std::ssize(movers); ++l) {
        const auto place = l - (own - movers.begin());
        const double share = place == 0 ? 0.5 : 1.0;
        Eigen::Vector3d turned = Eigen::Vector3d::Zero();
        if (place <= 0) turned += outer.cross(stretch.columns[a].col(l));
        if (place >= 0 && !model_.joints[movers[l].joint].slides()) {
          turned += Eigen::Vector3d(movers[l].sign * axes_.col(movers[l].dof)).cross(way);
        }
        column[movers[l].dof] += share * force * slope.dot(turned);
      }
      const Eigen::Vector3d moment = own->sign * force * arm.cross(slope);
      column[own->dof] += moment.dot(change + 0.5 * hinge.axis.cross(turn));
    }
  }
}

void PotentialEnergy::differentiateBySurface(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const int joint = joint_of_body_[p.item];
  Eigen::Vector3d shift = Eigen::Vector3d::Unit(p.component);
  if (joint >= 0) shift = links_[joint].rotation.col(p.component);
  const std::array<Eigen::Vector3d, 2> still = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const LongPath& path : paths_) {
    if (path.slack) continue;
    const Line& line = muscles_[path.line];
    for (const PlacedStretch& stretch : path.stretches) {
      const PathStretch& part = stretch.part;
      if (part.over < 0 || part.body != p.item || part.surface != p.part || !stretch.now.wrapped) continue;
      if (p.kind == StaticParameter::Kind::kSurfacePosition) {
        addStretchShift(
            path, stretch, still, shift, [](int) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); }, column);
        continue;
      }
      column += line.stiffness * part.weight * stretch.now.by_radius * path.by_dof;
      for (int a = 0; a < 2; ++a) {
        for (Eigen::Index k = 0; k < std::ssize(stretch.movers[a]); ++k) {
          column[stretch.movers[a][k].dof] +=
              line.force * part.weight * stretch.columns[a].col(k).dot(stretch.now.slope_by_radius[a]);
        }
      }
    }
  }
}

void PotentialEnergy::differentiateByTendon(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const Line& line = muscles_[p.item];
  const LongPath& path = paths_[line.path];
  if (path.slack) return;
  const PassiveTendon& tendon = model_.tendons[p.item - muscleCount()];
  column += tendon.kind->pull(tendon.p, line.length, line.shaft).by_parameter[p.component] * path.by_dof;
}

void PotentialEnergy::differentiateBySpring(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const Joint& joint = model_.joints[p.item];
  const int d = first_dof_[p.item];
  if (p.kind == StaticParameter::Kind::kSpringRest) {
    column[d] -= joint.spring_stiffness;
  } else if (joint.hasAxis()) {
    column[d] += positions_[p.item].angle - joint.spring_rest;
  } else {
    column.segment<3>(d) += logSo3(positions_[p.item].rotation);
  }
}

}  // namespace simgap
