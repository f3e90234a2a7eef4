#include "simgap/simulate/bullet_arm.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "simgap/core/error.h"
#include "simgap/simulate/bullet.h"
#include "simgap/simulate/joint_constraint_solver.h"

namespace simgap {
namespace {

constexpr double kRunawaySpeed = 1e4;  // [rad/s]; no arm turns that fast, a simulation that blows up passes it

}  // namespace

/// Bullet's objects, in the order they must be destroyed backwards.
struct BulletArm::World {
  /// A body's place in the multibody. Bullet wants link frames at the centre of mass along the principal axes.
  struct Link {
    int index = -1;                                            ///< -1: a fixed body, the multibody's base
    Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< in the body's frame
    Eigen::Quaterniond body_from_link = Eigen::Quaterniond::Identity();
  };

  btDefaultCollisionConfiguration collision_configuration;
  btCollisionDispatcher dispatcher{&collision_configuration};
  btSimpleBroadphase broadphase;
  JointConstraintSolver solver;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &collision_configuration};
  btMultiBody body;
  std::vector<Link> links;         ///< shape (bodies)
  std::vector<int> link_of_joint;  ///< shape (joints)

  explicit World(int number_of_links)
      : body(number_of_links, 0.0, btVector3(0.0, 0.0, 0.0), /*fixedBase=*/true, /*canSleep=*/false) {
    body.setHasSelfCollision(false);
    body.setLinearDamping(0.0);
    body.setAngularDamping(0.0);
    body.setMaxCoordinateVelocity(10.0 * kRunawaySpeed);  // Bullet clamps at 100 rad/s, which would hide a runaway
  }
  ~World() { world.removeMultiBody(&body); }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void addLink(int index, const Joint& joint, const MassProperties& mass);
};

void BulletArm::World::addLink(int index, const Joint& joint, const MassProperties& mass) {
  const Link& parent = links[joint.parent];
  Link& child = links[joint.child];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(mass.inertia);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  child = {index, mass.centre_of_mass, Eigen::Quaterniond(axes)};
  const Eigen::Quaterniond link_from_body = child.body_from_link.conjugate();

  const btVector3 inertia = toBullet(principal.eigenvalues());
  const btQuaternion child_from_parent = toBullet(link_from_body * parent.body_from_link);
  const btVector3 parent_to_pivot =
      toBullet(parent.body_from_link.conjugate() * (joint.parent_position - parent.centre_of_mass));
  const btVector3 pivot_to_child = toBullet(link_from_body * (child.centre_of_mass - joint.child_position));
  if (joint.type == JointType::kSpherical) {
    body.setupSpherical(index, mass.mass, inertia, parent.index, child_from_parent, parent_to_pivot, pivot_to_child,
                        true);
  } else {
    body.setupRevolute(index, mass.mass, inertia, parent.index, child_from_parent,
                       toBullet(link_from_body * joint.axis), parent_to_pivot, pivot_to_child, true);
  }
  link_of_joint.push_back(index);
}

/// What a step needs of a muscle, and its state.
struct BulletArm::MuscleState {
  MuscleState(const Muscle& muscle, double step)
      : attachments(muscle.attachments),
        kite_line_length(muscle.kite_line_length),
        shock_cord(muscle.shock_cord),
        spindle_radius(muscle.spindle_radius),
        supply_voltage(muscle.motor.supply_voltage),
        potentiometer_initial(muscle.potentiometer_initial),
        motor(muscle.motor),
        gearbox(muscle.gearbox),
        drive(muscle.motor, muscle.gearbox, step) {}

  void setModel(const Muscle& muscle, double step) {
    if (muscle.motor != motor || muscle.gearbox != gearbox) {
      *this = MuscleState(muscle, step);
      return;
    }
    attachments = muscle.attachments;
    kite_line_length = muscle.kite_line_length;
    shock_cord = muscle.shock_cord;
    spindle_radius = muscle.spindle_radius;
    potentiometer_initial = muscle.potentiometer_initial;
  }

  void reset() {
    state = {};
    reference = voltage = force = expansion = 0.0;
  }

  std::array<Attachment, 2> attachments;
  double kite_line_length;
  ShockCord shock_cord;
  double spindle_radius;
  double supply_voltage;
  double potentiometer_initial;
  Motor motor;
  Gearbox gearbox;
  Drive drive;
  DriveState state;
  double reference = 0.0;  ///< [rad]
  double voltage = 0.0;    ///< [V], held between controller ticks
  double force = 0.0;      ///< [N]
  double expansion = 0.0;  ///< of the cord, [m]
};

void BulletArmOptions::validate() const {
  if (!(step > 0.0 && step <= 0.01)) throw ConfigError(fmt::format("step_s: found {}, expected (0, 0.01] s", step));
  if (!(controller_rate > 0.0)) {
    throw ConfigError(fmt::format("controller_rate_Hz: found {}, expected > 0", controller_rate));
  }
  if (!(shaft_gain > 0.0)) throw ConfigError(fmt::format("shaft_gain_V_rad: found {}, expected > 0", shaft_gain));
  const double steps = 1.0 / (controller_rate * step);
  if (std::abs(steps - std::round(steps)) > 1e-6 || steps < 0.5) {
    throw ConfigError(fmt::format("step_s: found {} s, expected the controller's period {} s divided by a whole number",
                                  step, 1.0 / controller_rate));
  }
}

BulletArm::BulletArm(const ArmModel& model, const BulletArmOptions& options) : options_(options), observation_(model) {
  options_.validate();
  controller_steps_ = static_cast<int>(std::lround(1.0 / (options_.controller_rate * options_.step)));
  setModel(model);
}

BulletArm::~BulletArm() = default;
BulletArm::BulletArm(BulletArm&&) noexcept = default;
BulletArm& BulletArm::operator=(BulletArm&&) noexcept = default;

void BulletArm::build(const ArmModel& model) {
  bodies_ = model.bodies;
  joints_ = model.joints;
  gravity_ = model.gravity;
  start_ = startPosition(model);
  frames_.assign(bodies_.size(), {});
  spin_.assign(bodies_.size(), Eigen::Vector3d::Zero());
  drift_.assign(bodies_.size(), Eigen::Vector3d::Zero());
  world_ = std::make_unique<World>(static_cast<int>(joints_.size()));
  world_->links.resize(bodies_.size());
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    world_->addLink(static_cast<int>(j), joints_[j], massProperties(bodies_[joints_[j].child]));
  }
  world_->body.finalizeMultiDof();
  world_->world.addMultiBody(&world_->body);
  world_->world.setGravity(toBullet(gravity_));
  world_->solver.setArm(&world_->body, joints_, world_->link_of_joint);
}

void BulletArm::setModel(const ArmModel& model) {
  ArmModel extended;  // the model itself, where it has no extensions
  extensions_ = resolveExtensions(model);
  observation_.setModel(model);
  if (!extensions_.empty()) {
    extended = model;
    applyToModel(extensions_, extended);
    for (const auto& [effect, target, p] : extensions_) {
      if (effect->stiction) extended.joints[target].coulomb_friction = std::max(0.0, effect->stiction(p).torque);
    }
  }
  const ArmModel& plain = extensions_.empty() ? model : extended;
  if (!world_ || plain.bodies != bodies_ || plain.joints != joints_ || plain.gravity != gravity_) build(plain);
  crossed_.assign(extensions_.size(), {});
  for (std::size_t e = 0; e < extensions_.size(); ++e) {
    if (extensions_[e].effect->path) crossed_[e] = jointsCrossed(model, model.muscles[extensions_[e].target]);
  }
  if (muscles_.size() == model.muscles.size()) {
    for (std::size_t m = 0; m < muscles_.size(); ++m) muscles_[m].setModel(model.muscles[m], options_.step);
  } else {
    muscles_.clear();
    for (const Muscle& muscle : model.muscles) muscles_.emplace_back(muscle, options_.step);
  }
  reset();
}

void BulletArm::reset() {
  for (MuscleState& muscle : muscles_) muscle.reset();
  steps_ = 0;
  setJointPositions(start_);
}

void BulletArm::setShaftReferences(std::span<const double> references) {
  for (std::size_t m = 0; m < muscles_.size(); ++m) muscles_[m].reference = references[m];
}

void BulletArm::setJointPositions(std::span<const JointPosition> joints) {
  btMultiBody& body = world_->body;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const int link = world_->link_of_joint[j];
    std::array<btScalar, 4> position = {joints[j].angle, 0.0, 0.0, 0.0};
    if (joints_[j].type == JointType::kSpherical) {
      const Eigen::Quaterniond& body_from_link = world_->links[joints_[j].child].body_from_link;
      const Eigen::Quaterniond q = body_from_link.conjugate() * joints[j].rotation * body_from_link;
      position = {q.x(), q.y(), q.z(), q.w()};
    }
    body.setJointPosMultiDof(link, position.data());
    std::array<btScalar, 4> at_rest = {};
    body.setJointVelMultiDof(link, at_rest.data());
  }
  body.clearForcesAndTorques();
  world_->solver.reset();
  updateKinematics();
}

void BulletArm::setJointVelocity(std::size_t joint, const Eigen::Vector3d& velocity) {
  Eigen::Vector3d in_link = velocity;
  if (joints_[joint].type == JointType::kSpherical) {
    in_link = world_->links[joints_[joint].child].body_from_link.conjugate() * velocity;
  }
  std::array<btScalar, 4> coordinates = {in_link.x(), in_link.y(), in_link.z(), 0.0};
  world_->body.setJointVelMultiDof(world_->link_of_joint[joint], coordinates.data());
  updateKinematics();
}

void BulletArm::updateKinematics() {
  const btMultiBody& body = world_->body;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const BodyInWorld& parent = frames_[joint.parent];
    BodyInWorld& child = frames_[joint.child];
    const btScalar* velocity = const_cast<btMultiBody&>(body).getJointVelMultiDof(world_->link_of_joint[j]);
    const JointPosition position = jointPosition(j);
    child.rotation = parent.rotation * childInParent(joint, position);
    const Eigen::Vector3d relative_spin =
        joint.type == JointType::kSpherical
            ? world_->links[joint.child].body_from_link * Eigen::Vector3d(velocity[0], velocity[1], velocity[2])
            : Eigen::Vector3d(joint.axis * velocity[0]);
    spin_[joint.child] = spin_[joint.parent] + child.rotation * relative_spin;
    const Eigen::Vector3d to_joint = parent.rotation * joint.parent_position;
    const Eigen::Vector3d from_joint = child.rotation * joint.child_position;
    child.origin = parent.origin + to_joint - from_joint;
    drift_[joint.child] =
        drift_[joint.parent] + spin_[joint.parent].cross(to_joint) - spin_[joint.child].cross(from_joint);
  }
}

void BulletArm::applyForce(int body, const Eigen::Vector3d& from_origin, const Eigen::Vector3d& force) {
  const World::Link& link = world_->links[body];
  if (link.index < 0) return;
  const Eigen::Vector3d lever = from_origin - frames_[body].rotation * link.centre_of_mass;
  world_->body.addLinkForce(link.index, toBullet(force));
  world_->body.addLinkTorque(link.index, toBullet(lever.cross(force)));
}

/// Where a muscle's line runs, and how its length changes as the points that it touches move.
struct BulletArm::LinePath {
  struct Touch {
    int body;
    Eigen::Vector3d arm;    ///< from the body's origin, in the world [m]
    Eigen::Vector3d slope;  ///< of the length by the point
  };
  double length;  ///< [m]
  std::array<Touch, 2> ends;
  std::optional<Touch> centre;  ///< of the joint that bends it
};

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
  for (const LinePath::Touch& end : path.ends) applyForce(end.body, end.arm, -force * end.slope);
  if (path.centre) applyForce(path.centre->body, path.centre->arm, -force * path.centre->slope);
}

void BulletArm::applyMuscle(MuscleState& muscle, int index) {
  const LinePath path = linePath(muscle, index);

  // dL/dt = sum_a dL/dx_a . v_a with v_a = v_body + w_body x r_a.
  double rate = 0.0;
  const auto addRate = [&](const LinePath::Touch& touch) {
    rate += touch.slope.dot(Eigen::Vector3d(drift_[touch.body] + spin_[touch.body].cross(touch.arm)));
  };
  for (const LinePath::Touch& end : path.ends) addRate(end);
  if (path.centre) addRate(*path.centre);

  // The cord has what the kite line leaves of the path: L_S = L - (L_K0 - r phi) - dL(phi), and so
  // dL_S/dt = dL/dt + (r - d dL/dphi) dphi/dt (000 eq. 12 with what effects add to the line).
  Lengthening longer;
  for (const ArmExtension& extension : extensions_) {
    if (!extension.effect->line || !extension.on(index)) continue;
    const Lengthening one =
        extension.effect->line(extension.p, {muscle.state.shaft_angle, muscle.spindle_radius, pose_time_});
    longer.length += one.length;
    longer.by_shaft += one.by_shaft;
  }
  const double winding_radius = muscle.spindle_radius - longer.by_shaft;
  const double shaft_velocity = muscle.state.motor_velocity / muscle.drive.ratio();
  const double cord_length =
      path.length - (muscle.kite_line_length - muscle.spindle_radius * muscle.state.shaft_angle) - longer.length;
  const double cord_rate = rate + winding_radius * shaft_velocity;

  // F = max(0, k x + D dx/dt) while taut (000 eq. 3-4), with what effects add to k x.
  const ShockCord& cord = muscle.shock_cord;
  muscle.expansion = cord_length - cord.rest_length;
  muscle.force = cord.force(cord_length, cord_rate);
  double more = 0.0;
  for (const ArmExtension& extension : extensions_) {
    if (muscle.expansion <= 0.0 || !extension.effect->cord || !extension.on(index)) continue;
    more += extension.effect->cord(extension.p, muscle.expansion, cord).force;
  }
  if (more != 0.0) muscle.force = std::max(0.0, cord.stiffness * muscle.expansion + more + cord.damping * cord_rate);
  if (muscle.force > 0.0) pull(path, muscle.force);

  // The controller's voltage drives the shaft against the force at the winding radius.
  if (steps_ % controller_steps_ == 0) {
    muscle.voltage = std::clamp(options_.shaft_gain * (muscle.reference - muscle.state.shaft_angle),
                                -muscle.supply_voltage, muscle.supply_voltage);
  }
  muscle.drive.step(muscle.state, muscle.voltage, muscle.force * winding_radius);
}

void BulletArm::applyMuscles() {
  for (std::size_t m = 0; m < muscles_.size(); ++m) applyMuscle(muscles_[m], static_cast<int>(m));
}

void BulletArm::applyJointTorques() {
  for (const auto& [effect, target, p] : extensions_) {
    if (!effect->joint_torque) continue;
    const Joint& joint = joints_[target];
    const JointTerm term = effect->joint_torque(p, joint.type, jointPosition(static_cast<std::size_t>(target)));
    const Eigen::Vector3d in_child =
        joint.type == JointType::kSpherical ? term.gradient : Eigen::Vector3d(term.gradient.x() * joint.axis);
    const Eigen::Vector3d torque = frames_[joint.child].rotation * in_child;
    const int child = world_->links[joint.child].index;
    const int parent = world_->links[joint.parent].index;
    world_->body.addLinkTorque(child, toBullet(-torque));
    if (parent >= 0) world_->body.addLinkTorque(parent, toBullet(torque));
  }
}

void BulletArm::step() {
  applyMuscles();
  if (!extensions_.empty()) applyJointTorques();
  world_->world.stepSimulation(options_.step, 0);
  updateKinematics();
  ++steps_;
}

double BulletArm::time() const { return static_cast<double>(steps_) * options_.step; }

JointPosition BulletArm::jointPosition(std::size_t joint) const {
  JointPosition position;
  btMultiBody& body = world_->body;
  const btScalar* q = body.getJointPosMultiDof(world_->link_of_joint[joint]);
  if (joints_[joint].type == JointType::kSpherical) {
    const Eigen::Quaterniond& body_from_link = world_->links[joints_[joint].child].body_from_link;
    position.rotation = body_from_link * Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * body_from_link.conjugate();
  } else {
    position.angle = q[0];
  }
  return position;
}

std::vector<JointPosition> BulletArm::capturedPositions() const {
  std::vector<JointPosition> joints;
  for (std::size_t j = 0; j < joints_.size(); ++j) joints.push_back(jointPosition(j));
  observation_.turnMarkers(joints);
  return joints;
}

double BulletArm::jointSpeed(std::size_t joint) const {
  const btScalar* v = world_->body.getJointVelMultiDof(world_->link_of_joint[joint]);
  if (joints_[joint].type == JointType::kRevolute) return std::abs(v[0]);
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

bool BulletArm::isFinite() const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (!(jointSpeed(j) < kRunawaySpeed)) return false;
  }
  for (const MuscleState& muscle : muscles_) {
    if (!std::isfinite(muscle.state.shaft_angle) || !std::isfinite(muscle.force)) return false;
  }
  return true;
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
double BulletArm::cordExpansion(std::size_t muscle) const {
  return muscles_[muscle].expansion / muscles_[muscle].shock_cord.rest_length;
}
std::size_t BulletArm::joints() const { return joints_.size(); }
std::size_t BulletArm::muscles() const { return muscles_.size(); }

}  // namespace simgap
