#include "simgap/simulate/bullet_arm.h"

#include <fmt/format.h>

#include <cmath>

#include "bullet_arm_state.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {

void BulletArmOptions::validate() const {
  if (!(step >= 1e-7 && step <= 0.01))
    throw ConfigError(fmt::format("step_s: found {}, expected [1e-07, 0.01] s", step));
  if (!(controller_rate > 0.0)) {
    throw ConfigError(fmt::format("controller_rate_Hz: found {}, expected > 0", controller_rate));
  }
  if (!(shaft_gain > 0.0)) throw ConfigError(fmt::format("shaft_gain_V_rad: found {}, expected > 0", shaft_gain));
  if (drive_steps != 1 && drive_steps != 2) {
    throw ConfigError(fmt::format("drive_steps: found {}, expected 1 or 2", drive_steps));
  }
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
    const Joint& joint = joints_[j];
    world_->links[joint.child] = addLink(world_->body, static_cast<int>(j), joint, massProperties(bodies_[joint.child]),
                                         world_->links[joint.parent]);
    world_->link_of_joint.push_back(static_cast<int>(j));
  }
  world_->body.finalizeMultiDof();
  world_->gravity = toBullet(gravity_);
  world_->solver.setArm(&world_->body, joints_, world_->link_of_joint);
  motion_.reset();
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
    if (extensions_[e].effect->path) crossed_[e] = jointsCrossed(model, lineOf(model, extensions_[e].target));
  }
  if (muscles_.size() == model.muscles.size()) {
    for (std::size_t m = 0; m < muscles_.size(); ++m) muscles_[m].setModel(plain.muscles[m], driveStep());
  } else {
    muscles_.clear();
    for (const Muscle& muscle : plain.muscles) muscles_.emplace_back(muscle, driveStep());
    motion_.reset();
  }
  setMotionEffects();
  way_.clear();
  for (const Muscle& muscle : plain.muscles) {
    way_.push_back(muscle.straight() && !muscle.wrap ? PathParts{} : partsOf(muscle));
  }
  rope_of_.clear();
  ropes_.reset();
  if (std::ranges::any_of(plain.muscles, &Muscle::rope)) {
    int ropes = 0;
    for (const Muscle& muscle : plain.muscles) rope_of_.push_back(muscle.rope ? ropes++ : -1);
  }
  if (passive_.size() != model.tendons.size()) motion_.reset();
  passive_.clear();
  commanded_.clear();
  for (const PassiveTendon& tendon : plain.tendons) {
    if (tendon.kind->command) commanded_.push_back(passive_.size());
    passive_.push_back({tendon.kind, tendon.p, partsOf(tendon)});
  }
  reset();
}

void BulletArm::reset() {
  for (MuscleState& muscle : muscles_) muscle.reset();
  for (Passive& line : passive_) line.command = line.told = line.force = 0.0;
  steps_ = 0;
  setJointPositions(start_);
}

void BulletArm::setShaftReferences(std::span<const double> references) {
  for (std::size_t m = 0; m < muscles_.size(); ++m) muscles_[m].reference = references[m];
  setLineCommands(references.subspan(muscles_.size()), true);
}

void BulletArm::setJointPositions(std::span<const JointPosition> joints) {
  btMultiBody& body = world_->body;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const int link = world_->link_of_joint[j];
    const auto position = bulletPosition(joints_[j], world_->links[joints_[j].child], joints[j]);
    body.setJointPosMultiDof(link, position.data());
    std::array<btScalar, 4> at_rest = {};
    body.setJointVelMultiDof(link, at_rest.data());
  }
  body.clearForcesAndTorques();
  world_->solver.reset();
  forgetMotion();
  updateKinematics();
  layRopes();
}

void BulletArm::setJointVelocity(std::size_t joint, const Eigen::Vector3d& velocity) {
  const Eigen::Vector3d in_link = bulletVelocity(joints_[joint], world_->links[joints_[joint].child], velocity);
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
    const Eigen::Vector3d relative_spin = relativeSpin(joint, world_->links[joint.child], velocity);
    spin_[joint.child] = spin_[joint.parent] + child.rotation * relative_spin;
    const Eigen::Vector3d to_joint = parent.rotation * pivotInParent(joint, position);
    const Eigen::Vector3d from_joint = child.rotation * joint.child_position;
    child.origin = parent.origin + to_joint - from_joint;
    drift_[joint.child] =
        drift_[joint.parent] + spin_[joint.parent].cross(to_joint) - spin_[joint.child].cross(from_joint);
    if (joint.slides()) {
      drift_[joint.child] += parent.rotation * (joint.parent_orientation * joint.axis) * velocity[0];
    }
  }
}

void BulletArm::applyForce(int body, const Eigen::Vector3d& from_origin, const Eigen::Vector3d& force) {
  const BulletLink& link = world_->links[body];
  if (link.index < 0) return;
  const Eigen::Vector3d lever = from_origin - frames_[body].rotation * link.centre_of_mass;
  world_->body.addLinkForce(link.index, toBullet(force));
  world_->body.addLinkTorque(link.index, toBullet(lever.cross(force)));
}

void BulletArm::applyJointTorques() {
  for (const auto& [effect, target, p] : extensions_) {
    if (!effect->joint_torque) continue;
    const Joint& joint = joints_[target];
    pushJoint(joint, effect->joint_torque(p, joint.type, jointPosition(static_cast<std::size_t>(target))).gradient);
  }
}

/// Minus a gradient in the joint's coordinates, on the child and, the other way, on its parent.
void BulletArm::pushJoint(const Joint& joint, const Eigen::Vector3d& gradient) {
  const Eigen::Vector3d torque = frames_[joint.child].rotation * torqueInChild(joint, gradient);
  const int child = world_->links[joint.child].index;
  const int parent = world_->links[joint.parent].index;
  world_->body.addLinkTorque(child, toBullet(-torque));
  if (parent >= 0) world_->body.addLinkTorque(parent, toBullet(torque));
}

void BulletArm::applyJointSprings() {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    if (!joint.elastic()) continue;
    const Eigen::Vector3d gradient = springGradient(joint, jointPosition(j));
    if (joint.hasAxis()) {
      world_->body.addJointTorque(world_->link_of_joint[j], -gradient.x());
    } else {
      pushJoint(joint, gradient);
    }
  }
}

void BulletArm::step() {
  applyMuscles();
  if (!extensions_.empty()) applyJointTorques();
  applyJointSprings();
  world_->step(options_.step);
  updateKinematics();
  ++steps_;
}

double BulletArm::time() const { return static_cast<double>(steps_) * options_.step; }

JointPosition BulletArm::jointPosition(std::size_t joint) const {
  const btScalar* coordinates = world_->body.getJointPosMultiDof(world_->link_of_joint[joint]);
  return positionOf(joints_[joint], world_->links[joints_[joint].child], coordinates);
}

std::vector<JointPosition> BulletArm::capturedPositions() const {
  std::vector<JointPosition> joints(joints_.size());
  capturedPositions(joints);
  return joints;
}

void BulletArm::capturedPositions(std::vector<JointPosition>& joints) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) joints[j] = jointPosition(j);
  observation_.turnMarkers(joints);
}

double BulletArm::jointSpeed(std::size_t joint) const {
  const Joint& moving = joints_[joint];
  return kindOf(moving.type).counted * speed(moving, world_->body.getJointVelMultiDof(world_->link_of_joint[joint]));
}

double BulletArm::jointTravel(std::size_t joint, const JointPosition& from) const {
  const JointKind& kind = kindOf(joints_[joint].type);
  return kind.counted * kind.error(from, jointPosition(joint));
}

bool BulletArm::jointIsFinite(std::size_t joint) const { return jointSpeed(joint) < kRunawaySpeed; }

bool BulletArm::isFinite() const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (!jointIsFinite(j)) return false;
  }
  for (const MuscleState& muscle : muscles_) {
    if (!std::isfinite(muscle.state.shaft_angle) || !std::isfinite(muscle.force)) return false;
  }
  return true;
}

std::size_t BulletArm::joints() const { return joints_.size(); }
std::size_t BulletArm::muscles() const { return muscles_.size(); }

}  // namespace simgap
