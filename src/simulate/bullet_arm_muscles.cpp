// Muscles of BulletArm: the line through space, the cord's force, the drive behind it.
#include <cmath>

#include "bullet_arm_state.h"

namespace simgap {

BulletArm::LinePath BulletArm::linePath(const MuscleState& muscle, int index) const {
  LinePath path;
  std::array<Eigen::Vector3d, 2> point;
  for (std::size_t end = 0; end < 2; ++end) {
    const int body = muscle.attachments[end].body;
    path.ends[end].body = body;
    path.ends[end].arm = frames_[body].rotation * muscle.attachments[end].point;
    point[end] = frames_[body].origin + path.ends[end].arm;
  }
  // Straight: L = |x_1 - x_0|, dL/dx_1 = (x_1 - x_0) / L = -dL/dx_0.
  const Eigen::Vector3d line = point[1] - point[0];
  path.length = line.norm();
  path.ends[1].slope = path.length > 0.0 ? Eigen::Vector3d(line / path.length) : Eigen::Vector3d::Zero();
  path.ends[0].slope = -path.ends[1].slope;
  // Around a joint, if it touches one: moving all three points together changes nothing, so dL/dx_2 = -dL/dx_0 -
  // dL/dx_1.
  for (std::size_t e = 0; e < extensions_.size(); ++e) {
    const auto& [effect, target, p] = extensions_[e];
    if (!effect->path || target != index) continue;
    const Joint& joint = joints_[crossed_[e][static_cast<std::size_t>(std::lround(p[1])) - 1]];
    const Eigen::Vector3d centre = frames_[joint.parent] * joint.parent_position;
    BentPath bent;
    if (!effect->path(p, point[0] - centre, point[1] - centre, bent)) continue;
    path.length = bent.length;
    for (std::size_t end = 0; end < 2; ++end) path.ends[end].slope = bent.slope[end];
    path.centre = {joint.parent, frames_[joint.parent].rotation * joint.parent_position,
                   -bent.slope[0] - bent.slope[1]};
    break;
  }
  return path;
}

/// Virtual work: a line under the force F pulls at each point x_a with -F dL/dx_a.
void BulletArm::pull(const LinePath& path, double force) {
  for (const Touch& end : path.ends) applyForce(end.body, end.arm, -force * end.slope);
  if (path.centre) applyForce(path.centre->body, path.centre->arm, -force * path.centre->slope);
}

/// A line over a surface pulls on it where it meets and leaves it, along its free ends.
BulletArm::PathState BulletArm::followPath(const PathParts& way) {
  touches_.clear();
  PathState state{0.0, 0.0};
  Stretch stretch;
  for (const PathStretch& part : way.stretches) {
    placeStretch(bodies_, part, frames_, stretch);
    state.length += part.weight * stretch.length;
    for (std::size_t a = 0; a < 2; ++a) {
      const int body = part.ends[a].body;
      const Eigen::Vector3d slope = part.weight * stretch.slope[a];
      touches_.push_back({body, frames_[body].rotation * part.ends[a].point, slope});
      if (stretch.wrapped) touches_.push_back({part.body, stretch.touch[a] - frames_[part.body].origin, -slope});
    }
  }
  for (const Touch& touch : touches_) {
    state.rate += touch.slope.dot(Eigen::Vector3d(drift_[touch.body] + spin_[touch.body].cross(touch.arm)));
  }
  for (const PathWheel& wheel : way.wheels) {
    const int link = world_->link_of_joint[wheel.joint];
    state.length += wheel.weight * wheel.radius * world_->body.getJointPos(link);
    state.rate += wheel.weight * wheel.radius * world_->body.getJointVel(link);
  }
  return state;
}

BulletArm::CordState BulletArm::cordState(const MuscleState& muscle, int index, double path_length,
                                          const DriveState& drive) const {
  // The cord has what the kite line leaves of the path: L_S = L - (L_K0 - r phi) - dL(phi), and so
  // dL_S/dt = dL/dt + (r - d dL/dphi) dphi/dt (000 eq. 12 with what effects add to the line).
  const LineState line{drive.shaft_angle, muscle.spindle_radius, pose_time_,
                       shafts_before_.empty() ? 0.0 : shafts_before_[index],
                       muscle.kite_line_length - muscle.spindle_radius * drive.shaft_angle};
  Lengthening longer;
  for (const ArmExtension& extension : extensions_) {
    if (!extension.effect->line || !extension.on(index)) continue;
    const Lengthening one = extension.effect->line(extension.p, line);
    longer.length += one.length;
    longer.by_shaft += one.by_shaft;
  }
  CordState cord{};
  cord.winding_radius = muscle.spindle_radius - longer.by_shaft;
  cord.winding_rate = cord.winding_radius * (drive.motor_velocity / muscle.drive.ratio());
  cord.length = path_length - line.free - longer.length;
  cord.expansion = cord.length - muscle.shock_cord.rest_length;
  cord.elastic = muscle.shock_cord.stiffness * cord.expansion;
  for (const ArmExtension& extension : extensions_) {
    if (cord.expansion <= 0.0 || !extension.effect->cord || !extension.on(index)) continue;
    cord.elastic += extension.effect->cord(extension.p, cord.expansion, muscle.shock_cord, line).force;
  }
  if (muscle.yielded >= 0.0 && cord.expansion > 0.0) {
    cord.elastic += muscle.relaxation.share * muscle.shock_cord.stiffness * (cord.expansion - muscle.yielded);
  }
  return cord;
}

void BulletArm::pullPath(const PathParts& way, double force) {
  for (const Touch& touch : touches_) applyForce(touch.body, touch.arm, -force * touch.slope);
  for (const PathWheel& wheel : way.wheels) {
    world_->body.addJointTorque(world_->link_of_joint[wheel.joint], -force * wheel.weight * wheel.radius);
  }
}

void BulletArm::applyTendons() {
  for (const Passive& tendon : passive_) {
    const PathState state = followPath(tendon.way);
    const double force = tendon.kind->force(tendon.p, state.length, state.rate, tendon.command);
    if (force != 0.0) pullPath(tendon.way, force);
  }
}

void BulletArm::applyMuscle(MuscleState& muscle, int index) {
  const PathParts& way = way_[index];
  const bool straight = way.empty() && ropeOf(static_cast<std::size_t>(index)) < 0;
  LinePath path;
  double rate = 0.0;
  if (straight) {
    path = linePath(muscle, index);
    // dL/dt = sum_a dL/dx_a . v_a with v_a = v_body + w_body x r_a.
    const auto addRate = [&](const Touch& touch) {
      rate += touch.slope.dot(Eigen::Vector3d(drift_[touch.body] + spin_[touch.body].cross(touch.arm)));
    };
    for (const Touch& end : path.ends) addRate(end);
    if (path.centre) addRate(*path.centre);
  } else {
    const PathState state = followLine(static_cast<std::size_t>(index));
    path.length = state.length;
    rate = state.rate;
  }

  const CordState cord = cordState(muscle, index, path.length, muscle.state);
  const double cord_rate = rate + cord.winding_rate;

  // F = max(0, k x + D dx/dt) while taut (000 eq. 3-4).
  muscle.expansion = cord.expansion;
  muscle.force = cord.expansion > 0.0 ? std::max(0.0, cord.elastic + muscle.shock_cord.damping * cord_rate) : 0.0;
  if (muscle.force > 0.0) {
    if (straight) {
      pull(path, muscle.force);
    } else {
      pullPath(way, muscle.force);
    }
  }

  // The controller's voltage drives the shaft against the force at the winding radius.
  if (steps_ % controller_steps_ == 0) {
    muscle.voltage = std::clamp(options_.shaft_gain * (muscle.reference - muscle.state.shaft_angle),
                                -muscle.supply_voltage, muscle.supply_voltage);
  }
  muscle.drive.step(muscle.state, muscle.voltage, muscle.force * cord.winding_radius);
}

BulletArm::PathState BulletArm::followLine(std::size_t muscle) {
  const int rope = ropeOf(muscle);
  return rope < 0 ? followPath(way_[muscle]) : followRope(rope);
}

void BulletArm::applyMuscles() {
  if (ropes_) moveRopes();
  for (std::size_t m = 0; m < muscles_.size(); ++m) applyMuscle(muscles_[m], static_cast<int>(m));
  applyTendons();
}

double BulletArm::shaftAngle(std::size_t muscle) const { return muscles_[muscle].state.shaft_angle; }
double BulletArm::shaftError(std::size_t muscle) const {
  return muscles_[muscle].reference - muscles_[muscle].state.shaft_angle;
}
double BulletArm::potentiometer(std::size_t muscle) const {
  const MuscleState& m = muscles_[muscle];
  const double line = m.kite_line_length - m.spindle_radius * m.state.shaft_angle;
  return (line - m.kite_line_length) / m.spindle_radius + m.potentiometer_initial;
}
double BulletArm::force(std::size_t muscle) const { return muscles_[muscle].force; }
double BulletArm::current(std::size_t muscle) const { return muscles_[muscle].state.current; }
void BulletArm::addLineCommands(std::vector<double>& commands) const {
  for (const std::size_t line : commanded_) commands.push_back(passive_[line].command);
}
std::size_t BulletArm::lines() const { return commanded_.size(); }
double BulletArm::lineCommand(std::size_t line) const { return passive_[commanded_[line]].command; }
double BulletArm::lineForce(std::size_t line) const { return passive_[commanded_[line]].force; }
double BulletArm::cordExpansion(std::size_t muscle) const {
  return muscles_[muscle].expansion / muscles_[muscle].shock_cord.rest_length;
}

}  // namespace simgap
