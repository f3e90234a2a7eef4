// A step of BulletArm that is right on the way, not only where the arm rests. 000 and the pose protocol take Bullet's
// semi-implicit Euler step, whose Coriolis and gyroscopic terms are explicit: a tumbling ball joint is 10 % off in
// energy after a second at 2 ms. Here
//
//     q_1/2     = q_n + dt/2 v_n
//     M v_n+1   = M v_n + dt (tau(q_1/2, v) - h(q_1/2, v) - C v) + friction and limits,    v = (v_n + v_n+1) / 2
//     q_n+1     = q_1/2 + dt/2 v_n+1
//
// which is of second order, and implicit in all that depends on velocities: dampers of joints and cords are stable for
// any inertia, and a body that turns freely keeps its energy. Positions, velocities, friction and limits stay with
// Bullet's multibody and the solver of the joints' constraints. The drives are exact for a constant load (drive.h).
#include <cmath>

#include "bullet_arm_motion_state.h"
#include "invert_in_place.h"

namespace simgap {

void BulletArm::MotionDeleter::operator()(Motion* motion) const { delete motion; }

BulletArm::Motion& BulletArm::motion() {
  if (!motion_) motion_.reset(new Motion(bodies_, joints_, world_->links, muscles_.size() + passive_.size()));
  return *motion_;
}

void BulletArm::forgetMotion() {
  if (!motion_) return;
  motion_->change.setZero();
  motion_->pushed.setZero();
  for (Motion::Pull& pull : motion_->pulls) pull.winding_radius = 0.0;  // NaN after a motion that blew up
}

void BulletArm::setShafts(std::span<const double> shafts) {
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    muscles_[m].state = {0.0, 0.0, shafts[m]};
    muscles_[m].force = muscles_[m].voltage = 0.0;
  }
}

void BulletArm::setLineCommands(std::span<const double> commands, bool at_once) {
  for (std::size_t i = 0; i < std::min(commands.size(), commanded_.size()); ++i) {
    Passive& line = passive_[commanded_[i]];
    line.told = commands[i];
    if (at_once) line.command = line.told;
  }
}

/// dp/dt = (p_ref - p)/T, exactly for a command that holds.
void BulletArm::followCommands(double step) {
  for (const std::size_t i : commanded_) {
    Passive& line = passive_[i];
    const int lag = line.kind->command.lag;
    const double time = lag < 0 ? 0.0 : line.p[lag];
    line.command = time > 0.0 ? line.told + (line.command - line.told) * std::exp(-step / time) : line.told;
  }
}

void BulletArm::setVoltage(std::size_t muscle, double voltage) {
  const double supply = muscles_[muscle].supply_voltage;
  muscles_[muscle].voltage = std::clamp(voltage, -supply, supply);
}

/// dL/dq of the line that was followed last, over those wheels. \param[out] row  shape (dof)
void BulletArm::touchRow(const PathParts& way, Eigen::VectorXd& row) {
  row.setZero();
  for (const Touch& touch : touches_) {
    motion_->dynamics.addSlope(touch.body, frames_[touch.body].origin + touch.arm, touch.slope, row);
  }
  for (const PathWheel& wheel : way.wheels) {
    row[motion_->dynamics.firstDof(static_cast<std::size_t>(wheel.joint))] += wheel.weight * wheel.radius;
  }
}

double BulletArm::pathLength(std::size_t muscle) {
  const bool straight = way_[muscle].empty() && ropeOf(muscle) < 0;
  return straight ? linePath(muscles_[muscle], static_cast<int>(muscle)).length : followLine(muscle).length;
}

void BulletArm::placePull(std::size_t index, const DriveState& middle) {
  Motion::Pull& pull = motion_->pulls[index];
  MuscleState& muscle = muscles_[index];
  const PathParts& way = way_[index];
  double length = 0.0;
  if (way.empty() && ropeOf(index) < 0) {
    const LinePath path = linePath(muscle, static_cast<int>(index));
    length = path.length;
    pull.row.setZero();
    const auto add = [&](const Touch& touch) {
      motion_->dynamics.addSlope(touch.body, frames_[touch.body].origin + touch.arm, touch.slope, pull.row);
    };
    for (const Touch& end : path.ends) add(end);
    if (path.centre) add(*path.centre);
  } else {
    length = followLine(index).length;
    touchRow(way, pull.row);
  }

  // The force has two velocities: v_n, where the damper's part begins, and what v_n+1/2 is expected to be, which says
  // whether the cord pulls at all.
  const double rate = pull.row.dot(motion_->v), ahead = 0.5 * pull.row.dot(motion_->change);
  pull.damping = muscle.shock_cord.damping;
  const CordState cord = cordState(muscle, static_cast<int>(index), length, middle);
  pull.winding_radius = cord.winding_radius;
  muscle.expansion = cord.expansion;
  pull.force = cord.elastic + pull.damping * (rate + cord.winding_rate);
  pull.taut = cord.expansion > 0.0 && pull.force + pull.damping * ahead > 0.0;
}

/// A line without a motor: its force at v_n, and how it grows with the rate, of which it is linear while it pulls.
void BulletArm::placePassive(std::size_t index) {
  Motion::Pull& pull = motion_->pulls[muscles_.size() + index];
  const Passive& tendon = passive_[index];
  const double length = followPath(tendon.way).length;
  touchRow(tendon.way, pull.row);
  const double rate = pull.row.dot(motion_->v);
  pull.force = tendon.kind->force(tendon.p, length, rate, tendon.command);
  pull.damping = tendon.kind->force(tendon.p, length, rate + 1.0, tendon.command) - pull.force;
  pull.taut = pull.force != 0.0;  // a spring pushes, too
}

/// Minus a gradient in a joint's coordinates, as torque or force of its own.
void BulletArm::addJointGradient(std::size_t j, const Eigen::Vector3d& gradient) {
  Motion& m = *motion_;
  const Joint& joint = joints_[j];
  if (joint.hasAxis()) {
    m.tau[m.dynamics.firstDof(j)] -= gradient.x();
  } else {
    m.dynamics.addJointTorque(j, -(frames_[joint.child].rotation * torqueInChild(joint, gradient)), m.tau);
  }
}

void BulletArm::moveJoints(double step) {
  Motion& m = *motion_;
  const ArmDynamics& dynamics = m.dynamics;
  // (M + dt/2 (C + sum D J J^T)) (v_n+1 - v_n) = dt (tau(v_n) - h(v) - C v_n)
  m.tau = -m.viscous.cwiseProduct(m.v);
  m.mobility = dynamics.massMatrix();
  m.mobility.diagonal() += 0.5 * step * m.viscous;
  for (const Motion::Pull& pull : m.pulls) {
    if (!pull.taut) continue;
    m.tau -= pull.force * pull.row;
    for (Eigen::Index j = 0; j < m.tau.size(); ++j) {
      m.mobility.col(j) += (0.5 * step * pull.damping * pull.row[j]) * pull.row;
    }
  }
  for (const auto& [effect, target, p] : extensions_) {
    if (!effect->joint_torque) continue;
    const auto joint = static_cast<std::size_t>(target);
    addJointGradient(joint, effect->joint_torque(p, joints_[joint].type, jointPosition(joint)).gradient);
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (joints_[j].elastic()) addJointGradient(j, springGradient(joints_[j], jointPosition(j)));
  }
  if (guided_) m.inertia = m.mobility;
  invertInPlace(m.mobility);

  constexpr int kMostIterations = 8;
  constexpr double kTolerance = 1e-12;
  m.next = m.v + m.change - m.pushed;  // as in the step before
  for (int i = 0; i < kMostIterations; ++i) {
    // h belongs to the velocity that constraints leave: without them an arm that leans on a limit would feel a
    // Coriolis torque of second order in dt at rest. They push as in the step before.
    m.middle = 0.5 * (m.v + m.next + m.pushed);
    m.dynamics.bias(m.middle, gravity_, m.bias);
    m.scratch = step * (m.tau - m.bias);
    m.middle = m.next;
    m.next = m.v;
    for (Eigen::Index j = 0; j < m.scratch.size(); ++j) m.next += m.scratch[j] * m.mobility.col(j);
    if (!((m.next - m.middle).lpNorm<Eigen::Infinity>() > kTolerance * (1.0 + m.next.lpNorm<Eigen::Infinity>()))) break;
  }
  m.middle = m.next;
  if (guided_) slipGuides(step);
  world_->solver.addFrictionAndLimits(m.mobility, m.next, step);
  m.pushed = m.next - m.middle;
}

void BulletArm::stepMotion() {
  moveBodies();
  for (int part = 0; part < options_.drive_steps; ++part) stepDrives(part);
}

void BulletArm::moveBodies() {
  Motion& m = motion();
  const double step = options_.step;
  btMultiBody& body = world_->body;
  const Eigen::Map<const Eigen::VectorXd> velocity(body.getVelocityVector() + 6, m.v.size());
  m.v = velocity;

  if (supply_.resistance > 0.0) sagSupply();
  body.stepPositionsMultiDof(0.5 * step);
  updateKinematics();
  m.dynamics.place(frames_);
  if (ropes_) moveRopes();
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    const MuscleState& muscle = muscles_[i];
    DriveState end = muscle.state;  // were the load that of the step before
    muscle.stepDrive(end, muscle.force * m.pulls[i].winding_radius);
    const auto middle = [&](double now, double then) { return options_.drive_steps == 1 ? 0.5 * (now + then) : then; };
    placePull(i, {middle(muscle.state.current, end.current), middle(muscle.state.motor_velocity, end.motor_velocity),
                  middle(muscle.state.shaft_angle, end.shaft_angle)});
  }
  followCommands(0.5 * step);
  for (std::size_t t = 0; t < passive_.size(); ++t) placePassive(t);
  moveJoints(step);
  followCommands(0.5 * step);

  m.change = m.next - m.v;
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    MuscleState& muscle = muscles_[i];
    const Motion::Pull& pull = m.pulls[i];
    muscle.force = pull.taut ? std::max(0.0, pull.force + 0.5 * pull.damping * pull.row.dot(m.change)) : 0.0;
  }
  for (const std::size_t line : commanded_) {
    const Motion::Pull& pull = m.pulls[muscles_.size() + line];
    passive_[line].force = pull.taut ? pull.force + 0.5 * pull.damping * pull.row.dot(m.change) : 0.0;
  }
  Eigen::Map<Eigen::VectorXd>(const_cast<btScalar*>(body.getVelocityVector()) + 6, m.v.size()) = m.next;
  if (yielding_) yieldCords();
  body.stepPositionsMultiDof(0.5 * step);
  updateKinematics();
  ++steps_;
}

void BulletArm::stepDrives(int part) {
  if (part > 0 && supply_.resistance > 0.0) sagSupply();
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    muscles_[i].stepDrive(muscles_[i].state, muscles_[i].force * motion_->pulls[i].winding_radius);
  }
}

double BulletArm::mechanicalEnergy() {
  Motion& m = motion();
  m.dynamics.place(frames_);
  const Eigen::Map<const Eigen::VectorXd> v(world_->body.getVelocityVector() + 6, m.v.size());
  double energy = 0.5 * v.dot(m.dynamics.massMatrix().lazyProduct(v)) + m.dynamics.gravityEnergy(gravity_);
  for (std::size_t i = 0; i < muscles_.size(); ++i) {
    const MuscleState& muscle = muscles_[i];
    const CordState cord = cordState(muscle, static_cast<int>(i), pathLength(i), muscle.state);
    if (cord.expansion > 0.0) energy += 0.5 * muscle.shock_cord.stiffness * cord.expansion * cord.expansion;
  }
  for (const Passive& tendon : passive_) {
    energy += tendon.kind->pull(tendon.p, followPath(tendon.way).length, tendon.command).energy;
  }
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (joints_[j].elastic()) energy += springEnergy(joints_[j], jointPosition(j));
  }
  return energy;
}

Eigen::Vector3d BulletArm::jointVelocity(std::size_t joint) const {
  const Eigen::Vector3d spin = relativeSpin(joints_[joint], world_->links[joints_[joint].child],
                                            world_->body.getJointVelMultiDof(world_->link_of_joint[joint]));
  if (!joints_[joint].hasAxis()) return spin;
  return {world_->body.getJointVel(world_->link_of_joint[joint]), 0.0, 0.0};
}

double BulletArm::voltage(std::size_t muscle) const { return muscles_[muscle].voltage; }
double BulletArm::shaftVelocity(std::size_t muscle) const {
  return muscles_[muscle].state.motor_velocity / muscles_[muscle].drive.ratio();
}
double BulletArm::cordLength(std::size_t muscle) const {
  return muscles_[muscle].expansion + muscles_[muscle].shock_cord.rest_length;
}

}  // namespace simgap
