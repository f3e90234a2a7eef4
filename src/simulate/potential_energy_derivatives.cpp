/// Derivatives of the energy's gradient G with respect to the model's numbers. All that move a point reduce to one
/// case: end 1 of a muscle shifts by s (end 0: the same with -s). With k the stiffness, F the force, L the length,
///
///   dG_c = s . [(k - F/L) (u.d_c) u + F/L d_c + F (u x a_c) when the shift changes the point's arm about dof c],
///
/// d_c = dd/dq_c. A body's weight is the same with the force -m g and neither k nor F/L.
#include <cassert>

#include "simgap/core/error.h"
#include "simgap/model/parameter_space.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

using Kind = StaticParameter::Kind;

void PotentialEnergy::differentiate(std::span<const StaticParameter> parameters,
                                    Eigen::Ref<Eigen::MatrixXd> columns) const {
  assert(columns.rows() == degreesOfFreedom() && columns.cols() == static_cast<Eigen::Index>(parameters.size()));
  columns.setZero();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    differentiateBy(parameters[p], columns.col(static_cast<Eigen::Index>(p)));
  }
}

void PotentialEnergy::differentiateByShafts(Eigen::Ref<Eigen::MatrixXd> columns) const {
  columns.setZero();
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const Line& line = muscles_[m];
    if (line.force == 0.0) continue;
    const double stretch = model_.muscles[m].shock_cord.stiffness * model_.muscles[m].spindle_radius;
    for (int b = line.first; b < line.last; ++b) {
      columns(levers_[b].dof, static_cast<Eigen::Index>(m)) = stretch * levers_[b].lever;
    }
  }
}

void PotentialEnergy::differentiateBy(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  switch (p.kind) {
    case Kind::kNone:
      return;
    case Kind::kGravity:
      for (int c = 0; c < degreesOfFreedom(); ++c) {
        const Link& link = links_[dofs_[c].joint];
        column[c] = -dofs_[c].axis.cross(link.moment - link.subtree_mass * link.pivot)[p.component];
      }
      return;
    case Kind::kParentPosition: {
      const int above = parent_joint_[p.item];
      const Eigen::Vector3d shift = above < 0 ? Eigen::Vector3d(Eigen::Vector3d::Unit(p.component))
                                              : Eigen::Vector3d(links_[above].rotation.col(p.component));
      return differentiateByJointShift(p.item, shift, true, column);
    }
    case Kind::kChildPosition:
      return differentiateByJointShift(p.item, -links_[p.item].rotation.col(p.component), false, column);
    case Kind::kPartMass:
    case Kind::kPartPosition:
      return differentiateByMass(p, column);
    default:
      return differentiateByMuscle(p, column);
  }
}

Eigen::Vector3d PotentialEnergy::stretchTerm(const Line& line, const Muscle& muscle, const Lever& lever) const {
  const double pull = line.force / line.length;
  return (muscle.shock_cord.stiffness - pull) * lever.lever * line.direction + pull * lever.move;
}

void PotentialEnergy::differentiateByMuscle(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const Line& line = muscles_[p.item];
  if (line.force == 0.0) return;
  const Muscle& muscle = model_.muscles[p.item];
  const double stiffness = muscle.shock_cord.stiffness;
  double factor = 0.0;  // of the lever
  switch (p.kind) {
    case Kind::kKiteLine:
    case Kind::kRestLength:
      factor = -stiffness;
      break;
    case Kind::kStiffness:
      factor = line.expansion;
      break;
    case Kind::kSpindleRadius:
      factor = stiffness * line.shaft;
      break;
    default: {
      assert(p.kind == Kind::kAttachment);
      const int joint = line.joint[p.part];
      Eigen::Vector3d shift = Eigen::Vector3d::Unit(p.component);
      if (joint >= 0) shift = links_[joint].rotation.col(p.component);
      const double sign = p.part == 1 ? 1.0 : -1.0;
      for (int b = line.first; b < line.last; ++b) {
        const Lever& lever = levers_[b];
        Eigen::Vector3d term = stretchTerm(line, muscle, lever);
        if (lever.end == p.part) term += line.force * lever.turn;
        column[lever.dof] += sign * shift.dot(term);
      }
      return;
    }
  }
  for (int b = line.first; b < line.last; ++b) column[levers_[b].dof] += factor * levers_[b].lever;
}

void PotentialEnergy::differentiateByMass(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const int joint = joint_of_body_[p.item];
  if (joint < 0) return;
  const Part& part = model_.bodies[p.item].parts[p.part];
  const Eigen::Vector3d& g = model_.gravity;
  for (int c = 0; c < degreesOfFreedom(); ++c) {
    if (!carries(dofs_[c].joint, joint)) continue;
    const Eigen::Vector3d& axis = dofs_[c].axis;
    if (p.kind == Kind::kPartMass) {
      column[c] -= g.dot(axis.cross(pointInWorld(joint, part.position) - links_[dofs_[c].joint].pivot));
    } else {
      column[c] -= part.mass * g.dot(axis.cross(links_[joint].rotation.col(p.component)));
    }
  }
}

void PotentialEnergy::differentiateByJointShift(int joint, const Eigen::Vector3d& shift, bool pivot_moves,
                                                Eigen::Ref<Eigen::VectorXd> column) const {
  // The arm about a pivot changes when the point moves and the pivot does not.
  const auto changesArm = [&](int dof) {
    const int j = dofs_[dof].joint;
    return pivot_moves ? j != joint && carries(j, joint) : carries(j, joint);
  };
  for (int c = 0; c < degreesOfFreedom(); ++c) {
    if (changesArm(c)) column[c] -= links_[joint].subtree_mass * model_.gravity.dot(dofs_[c].axis.cross(shift));
  }
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const Line& line = muscles_[m];
    if (line.force == 0.0) continue;
    std::array<bool, 2> shifts;
    for (int end = 0; end < 2; ++end) shifts[end] = line.joint[end] >= 0 && carries(joint, line.joint[end]);
    for (int end = 0; end < 2; ++end) {
      if (!shifts[end] || shifts[1 - end]) continue;
      const double sign = end == 1 ? 1.0 : -1.0;
      for (int b = line.first; b < line.last; ++b) {
        const Lever& lever = levers_[b];
        Eigen::Vector3d term = stretchTerm(line, model_.muscles[m], lever);
        if (lever.end == end && changesArm(lever.dof)) term += line.force * lever.turn;
        column[lever.dof] += sign * shift.dot(term);
      }
    }
  }
}

namespace {

constexpr std::pair<std::string_view, Kind> kMuscleMembers[] = {
    {"attachments.0.point_m", Kind::kAttachment},   {"attachments.1.point_m", Kind::kAttachment},
    {"kite_line_length_m", Kind::kKiteLine},        {"shock_cord.rest_length_m", Kind::kRestLength},
    {"shock_cord.stiffness_N_m", Kind::kStiffness}, {"spindle_radius_m", Kind::kSpindleRadius},
};

template <class Items>
int indexOf(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

StaticParameter staticParameter(const ArmModel& model, const ParameterPath& path) {
  StaticParameter parameter{Kind::kNone, 0, 0, std::max(0, path.component)};
  if (path.group == "gravity_m_s2") {
    parameter.kind = Kind::kGravity;
  } else if (path.group == "muscles") {
    parameter.item = indexOf(model.muscles, path.item);
    for (const auto& [member, kind] : kMuscleMembers) {
      if (path.member == member) parameter.kind = kind;
    }
    parameter.part = path.member == "attachments.1.point_m" ? 1 : 0;
  } else if (path.group == "joints") {
    parameter.item = indexOf(model.joints, path.item);
    if (path.member == "parent_position_m") parameter.kind = Kind::kParentPosition;
    if (path.member == "child_position_m") parameter.kind = Kind::kChildPosition;
  } else if (path.group == "bodies") {
    parameter.item = indexOf(model.bodies, path.item);
    const auto dot = path.member.rfind('.');
    parameter.part = indexOf(model.bodies[parameter.item].parts, path.member.substr(0, dot));
    parameter.kind = path.member.ends_with(".mass_kg") ? Kind::kPartMass : Kind::kPartPosition;
  }
  return parameter;
}

}  // namespace

std::vector<StaticParameter> staticParameters(const ArmModel& model, std::span<const std::string> paths) {
  std::vector<StaticParameter> parameters(paths.size());
  std::size_t found = 0;
  ArmModel copy = model;
  visitParameters(copy, [&](const ParameterPath& path, const ParameterKind&, double&) {
    const std::string name = path.str();
    for (std::size_t p = 0; p < paths.size(); ++p) {
      if (paths[p] != name) continue;
      parameters[p] = staticParameter(model, path);
      ++found;
    }
  });
  if (found != paths.size()) throw ConfigError("a parameter is not one of the model");
  return parameters;
}

}  // namespace simgap
