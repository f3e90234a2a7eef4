/// Derivatives of the energy's gradient with respect to the model's numbers. All that move a point reduce to one case:
/// end 1 of a muscle shifts by s (end 0: the same with -s). With k the stiffness, F the force, L the length, t = dL/dw,
///
///   d(F t) = (k - F/L) (u.s) t + F/L (+-r x s) + F s x u,   the last when the shift changes the arm r about the pivot.
///
/// A body's weight is the same with the force -m g and neither k nor F/L.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include "simgap/core/error.h"
#include "simgap/core/names.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

using Kind = StaticParameter::Kind;

void PotentialEnergy::differentiate(std::span<const StaticParameter> parameters,
                                    Eigen::Ref<Eigen::MatrixXd> columns) const {
  assert(columns.rows() == degreesOfFreedom() && columns.cols() == static_cast<Eigen::Index>(parameters.size()));
  columns.setZero();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    differentiateBy(parameters[p], columns.col(p));
  }
}

void PotentialEnergy::addProjected(int joint, const Eigen::Vector3d& derivative,
                                   Eigen::Ref<Eigen::VectorXd> column) const {
  const int d = first_dof_[joint];
  if (!model_.joints[joint].hasAxis()) {
    const Link& link = links_[joint];
    column.segment<3>(d) += (link.turned ? link.basis : link.rotation).transpose() * derivative;
  } else {
    column[d] += links_[joint].axis.dot(derivative);
  }
}

/// Moment of all weights below a joint about its pivot, per gravity along `direction`; of a slide their sum.
Eigen::Vector3d PotentialEnergy::liftArm(int joint, const Eigen::Vector3d& direction) const {
  const Link& link = links_[joint];
  if (model_.joints[joint].slides()) return link.subtree_mass * direction;
  return (link.moment - link.subtree_mass * link.pivot).cross(direction);
}

void PotentialEnergy::addForce(std::size_t m, double factor, Eigen::Ref<Eigen::VectorXd> column) const {
  const Line& line = muscles_[m];
  if (line.path >= 0) {
    column += factor * paths_[line.path].by_dof;
    return;
  }
  if (line.bend >= 0) {
    const Bend& bend = bends_[line.bend];
    for (int j = 0; j < std::ssize(links_); ++j) addProjected(j, factor * bend.moment[j], column);
    return;
  }
  for (int b = line.first; b < line.last; ++b) addProjected(levers_[b].joint, factor * levers_[b].moment, column);
}

void PotentialEnergy::differentiateByShafts(Eigen::Ref<Eigen::MatrixXd> columns) const {
  columns.setZero();
  for (std::size_t m = 0; m < model_.muscles.size(); ++m) {
    const Line& line = muscles_[m];
    if (line.force == 0.0) continue;
    // dF/dphi = k dx/dphi = k (r - d dL/dphi).
    const double radius = model_.muscles[m].spindle_radius;
    const double by_shaft = line.extended ? lengthening(m).by_shaft : 0.0;
    const double by_free = line.extended ? cordTerm(m).by_free : 0.0;
    addForce(m, line.stiffness * (radius - by_shaft) - by_free * radius, columns.col(m));
  }
  auto column = std::ssize(model_.muscles);
  for (std::size_t t = 0; t < model_.tendons.size(); ++t) {
    if (!model_.tendons[t].kind->command) continue;
    const Line& line = muscles_[model_.muscles.size() + t];
    columns.col(column++) += line.by_command * paths_[line.path].by_dof;
  }
}

void PotentialEnergy::differentiateBy(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  switch (p.kind) {
    case Kind::kNone:
      return;
    case Kind::kExtension:
      return differentiateByExtension(p.item, p.component, column);
    case Kind::kGravity: {
      // dV/dw_j = -arm_j x g' with g' = G g, G the effects' turns: d/dg_k is -arm_j x (G e_k).
      Eigen::Vector3d change = Eigen::Vector3d::Unit(p.component);
      for (const Applied& applied : applied_) change = (applied.gravity.by_gravity * change).eval();
      for (int j = 0; j < std::ssize(links_); ++j) {
        addProjected(j, -liftArm(j, change), column);
      }
      return;
    }
    case Kind::kParentPosition: {
      Eigen::Vector3d shift = Eigen::Vector3d::Unit(p.component);
      if (parent_joint_[p.item] >= 0) shift = links_[parent_joint_[p.item]].rotation.col(p.component);
      return differentiateByJointShift(p.item, shift, true, column);
    }
    case Kind::kChildPosition:
      differentiateByJointShift(p.item, -links_[p.item].rotation.col(p.component), false, column);
      // A wrap stands at the joint's centre: it does not go along when its place on the child changes.
      for (std::size_t e = 0; e < extensions_.size(); ++e) {
        if (!extensions_[e].effect->path || !wrapsAsSurface(model_, extensions_[e].target)) continue;
        const int body = pathOf(extensions_[e].target).wrap->body;
        if (body != model_.joints[p.item].child) continue;
        differentiateBySurface({Kind::kSurfacePosition, body, applied_[e].part, p.component}, column);
      }
      return;
    case Kind::kPartMass:
    case Kind::kPartPosition:
      return differentiateByMass(p, column);
    case Kind::kSurfaceRadius:
    case Kind::kSurfacePosition:
      return differentiateBySurface(p, column);
    case Kind::kTendonParameter:
      return differentiateByTendon(p, column);
    case Kind::kSpringStiffness:
    case Kind::kSpringRest:
      return differentiateBySpring(p, column);
    default:
      return differentiateByMuscle(p, column);
  }
}

Eigen::Vector3d PotentialEnergy::shiftTerm(const Line& line, const Lever& lever, int end, const Eigen::Vector3d& shift,
                                           bool arm_changes) const {
  const double pull = line.force / line.length;
  const double sign = lever.end == 1 ? 1.0 : -1.0;
  Eigen::Vector3d term =
      (line.stiffness - pull) * line.direction.dot(shift) * lever.moment + pull * sign * lever.arm.cross(shift);
  if (lever.end == end && arm_changes) term += line.force * shift.cross(line.direction);
  return end == 1 ? term : Eigen::Vector3d(-term);
}

void PotentialEnergy::differentiateByMuscle(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const auto m = static_cast<std::size_t>(p.item);
  const Line& line = muscles_[m];
  const bool of_path = p.kind == Kind::kAttachment || p.kind == Kind::kWheelRadius;
  if (line.path >= 0 && of_path) return differentiatePathByStation(paths_[line.path], p, column);
  if (line.force == 0.0) return;
  // The numbers of the line change F alone: dF = k dx + x dk with x = L - L_K0 + r phi - dL - L_SR.
  switch (p.kind) {
    case Kind::kKiteLine:
      return addForce(m, -line.stiffness + (line.extended ? cordTerm(m).by_free : 0.0), column);
    case Kind::kRestLength:
      return addForce(m, -line.stiffness + (line.extended ? cordTerm(m).by_rest_length : 0.0), column);
    case Kind::kStiffness:
      return addForce(m, line.expansion + (line.extended ? cordTerm(m).by_stiffness : 0.0), column);
    case Kind::kSpindleRadius:
      return addForce(m,
                      line.stiffness * (line.shaft - (line.extended ? lengthening(m).by_radius : 0.0)) -
                          (line.extended ? cordTerm(m).by_free * line.shaft : 0.0),
                      column);
    default:
      break;
  }
  // An attachment shifts its end by s, a column of its body's rotation.
  assert(p.kind == Kind::kAttachment);
  const int joint = line.joint[p.part];
  Eigen::Vector3d shift = Eigen::Vector3d::Unit(p.component);
  if (joint >= 0) shift = links_[joint].rotation.col(p.component);
  if (line.bend >= 0) {
    const Bend& bend = bends_[line.bend];
    const std::array<bool, 3> moved = {p.part == 0, p.part == 1, false};
    for (int j = 0; j < std::ssize(links_); ++j) {
      addProjected(j, bendShiftTerm(line, bend, j, shift, moved, true), column);
    }
    return;
  }
  for (int b = line.first; b < line.last; ++b) {
    addProjected(levers_[b].joint, shiftTerm(line, levers_[b], p.part, shift, true), column);
  }
}

/// The weight -m g of a point: its mass changes by `mass_change`, or it moves by `way` along `direction`.
void PotentialEnergy::addWeight(int joint, const Eigen::Vector3d& point, double mass, const Eigen::Vector3d& direction,
                                double mass_change, double way, Eigen::Ref<Eigen::VectorXd> column) const {
  for (int j = joint; j >= 0; j = parent_joint_[j]) {
    if (model_.joints[j].slides()) {
      addProjected(j, -mass_change * model_.gravity, column);
      continue;
    }
    const Eigen::Vector3d move = mass_change * (point - links_[j].pivot) + mass * way * direction;
    addProjected(j, -move.cross(model_.gravity), column);
  }
}

void PotentialEnergy::differentiateByMass(const StaticParameter& p, Eigen::Ref<Eigen::VectorXd> column) const {
  const int joint = joint_of_body_[p.item];
  if (joint < 0) return;
  const Part& part = model_.bodies[p.item].parts[p.part];
  const bool by_mass = p.kind == Kind::kPartMass;
  addWeight(joint, pointInWorld(joint, part.position), part.mass, links_[joint].rotation.col(p.component),
            by_mass ? 1.0 : 0.0, by_mass ? 0.0 : 1.0, column);
}

void PotentialEnergy::differentiateByJointShift(int joint, const Eigen::Vector3d& shift, bool pivot_moves,
                                                Eigen::Ref<Eigen::VectorXd> column) const {
  // Everything below the joint shifts by s. The arm about a pivot changes when the point moves and the pivot does not.
  const auto changesArm = [&](int j) { return carries(j, joint) && !(pivot_moves && j == joint); };
  for (int j = joint; j >= 0; j = parent_joint_[j]) {
    if (changesArm(j) && !model_.joints[j].slides())
      addProjected(j, -links_[joint].subtree_mass * shift.cross(model_.gravity), column);
  }
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const Line& line = muscles_[m];
    if (line.path >= 0) {
      differentiatePathByJointShift(paths_[line.path], joint, shift, pivot_moves, column);
      continue;
    }
    if (line.force == 0.0) continue;
    if (line.bend >= 0) {
      const Bend& bend = bends_[line.bend];
      const auto below = [&](int point) { return bend.carrier[point] >= 0 && carries(joint, bend.carrier[point]); };
      const std::array<bool, 3> moved = {below(0), below(1), below(2) || (pivot_moves && bend.obstacle == joint)};
      for (int j = 0; j < std::ssize(links_); ++j) {
        addProjected(j, bendShiftTerm(line, bend, j, shift, moved, changesArm(j)), column);
      }
      continue;
    }
    for (int end = 0; end < 2; ++end) {
      const auto shifts = [&](int e) { return line.joint[e] >= 0 && carries(joint, line.joint[e]); };
      if (!shifts(end) || shifts(1 - end)) continue;
      for (int b = line.first; b < line.last; ++b) {
        const int j = levers_[b].joint;
        addProjected(j, shiftTerm(line, levers_[b], end, shift, changesArm(j)), column);
      }
    }
  }
}

/// A change da of the unit axis turns all below by w = (1 - cos q) a x da + sin q da: Q(a, q) goes to exp(w) Q. What a
/// joint's gradient changes by is then its block's part of w; of the hinge's own, a . M,
///
///   d(a . M) = da . M + a . H w + M . (a x w) / 2,
///
/// the last as H is the symmetric part of the turns of one joint, w before a.
void PotentialEnergy::differentiateByAxis(int joint, const Eigen::Vector3d& change,
                                          Eigen::Ref<Eigen::VectorXd> column) const {
  const Eigen::Vector3d& axis = links_[joint].axis;
  const double q = positions_[joint].angle;
  const Eigen::Vector3d turn = (1.0 - std::cos(q)) * axis.cross(change) + std::sin(q) * change;
  const auto joints = std::ssize(links_);
  for (int j = 0; j < joints; ++j) {
    const Eigen::Matrix3d& block = blocks_[std::min(j, joint) * joints + std::max(j, joint)];
    addProjected(j, j > joint ? Eigen::Vector3d(block.transpose() * turn) : Eigen::Vector3d(block * turn), column);
  }
  column[first_dof_[joint]] += moments_[joint].dot(change + 0.5 * axis.cross(turn));
  for (const LongPath& path : paths_) differentiatePathByAxis(path, joint, change, turn, column);
}

namespace {

constexpr std::pair<std::string_view, Kind> kMuscleMembers[] = {
    {"kite_line_length_m", Kind::kKiteLine},
    {"shock_cord.rest_length_m", Kind::kRestLength},
    {"shock_cord.stiffness_N_m", Kind::kStiffness},
    {"spindle_radius_m", Kind::kSpindleRadius},
};

/// \param label  "effect:target"
int extensionIndex(const ArmModel& model, std::string_view label) {
  const auto found = std::ranges::find_if(model.extensions, [&](const Extension& extension) {
    return effectLabel(extension.effect, extension.target) == label;
  });
  assert(found != model.extensions.end());
  return static_cast<int>(found - model.extensions.begin());
}

/// \param member  "attachments.2.point_m" or "attachments.2.radius_m"; of a line over joints alone 0 is the first wheel
void findStation(std::string_view member, const TendonPath& path, StaticParameter& parameter) {
  if (!member.starts_with("attachments.")) return;
  parameter.kind = member.ends_with(".radius_m") ? Kind::kWheelRadius : Kind::kAttachment;
  parameter.part = std::atoi(std::string(member.substr(member.find('.') + 1)).c_str()) + (path.jointsOnly() ? 1 : 0);
}

StaticParameter staticParameter(const ArmModel& model, const ParameterPath& path) {
  StaticParameter parameter{Kind::kNone, 0, 0, std::max(0, path.component)};
  if (path.group == "gravity_m_s2") {
    parameter.kind = Kind::kGravity;
  } else if (path.group == "extensions") {
    parameter.kind = Kind::kExtension;
    parameter.item = extensionIndex(model, path.item);
    const auto& parameters = model.extensions[parameter.item].parameters;
    parameter.component = indexOf(parameters, path.member);
  } else if (path.group == "muscles") {
    parameter.item = indexOf(model.muscles, path.item);
    for (const auto& [member, kind] : kMuscleMembers) {
      if (path.member == member) parameter.kind = kind;
    }
    findStation(path.member, model.muscles[parameter.item], parameter);
  } else if (path.group == "tendons") {
    const int tendon = indexOf(model.tendons, path.item);
    parameter.item = static_cast<int>(model.muscles.size()) + tendon;
    const auto& known = model.tendons[tendon].kind->parameters;
    const auto found = std::ranges::find(known, path.member, &TendonParameter::key);
    if (found != known.end()) {
      parameter.kind = Kind::kTendonParameter;
      parameter.component = static_cast<int>(found - known.begin());
    }
    findStation(path.member, model.tendons[tendon], parameter);
  } else if (path.group == "joints") {
    parameter.item = indexOf(model.joints, path.item);
    if (path.member == "parent_position_m") parameter.kind = Kind::kParentPosition;
    if (path.member == "child_position_m") parameter.kind = Kind::kChildPosition;
    if (path.member.starts_with("spring.stiffness")) parameter.kind = Kind::kSpringStiffness;
    if (path.member.starts_with("spring.rest")) parameter.kind = Kind::kSpringRest;
  } else if (path.group == "bodies") {
    parameter.item = indexOf(model.bodies, path.item);
    const auto dot = path.member.rfind('.');
    const Body& body = model.bodies[parameter.item];
    parameter.part = indexOf(body.parts, path.member.substr(0, dot));
    parameter.kind = path.member.ends_with(".mass_kg") ? Kind::kPartMass : Kind::kPartPosition;
    if (parameter.part >= 0) return parameter;
    parameter.part = indexOf(body.surfaces, path.member.substr(0, dot));
    parameter.kind = path.member.ends_with(".radius_m") ? Kind::kSurfaceRadius : Kind::kSurfacePosition;
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
