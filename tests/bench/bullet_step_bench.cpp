/// \file
/// What a step of the arm costs beside a bare Bullet world with the same bodies, joints, limits and friction
/// constraints.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/bullet.h"
#include "simgap/simulate/pose_protocol.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodySphericalJointMotor.h>

namespace simgap {
namespace {

const std::string kData = std::string(SIMGAP_SOURCE_DIR) + "/data/arm/";

ArmModel sampleArm() { return readArm(YamlNode::load(kData + "arm.yaml")); }

PoseSet samplePoses(const ArmModel& model) {
  return readPoseSet(CsvTable::load(kData + "poses_calibration.csv"), model.poseLayout());
}

/// Two links as in the sample arm, built with nothing but Bullet.
class BareWorld {
 public:
  BareWorld(bool constraints, int iterations) {
    body_.setHasSelfCollision(false);
    body_.setLinearDamping(0.0);
    body_.setAngularDamping(0.0);
    const btQuaternion aligned(0.0, 0.0, 0.0, 1.0);
    body_.setupSpherical(0, 1.05, btVector3(0.0056, 0.0056, 0.00023), -1, aligned, btVector3(0, 0, 0),
                         btVector3(0, 0.004, -0.125), true);
    body_.setupRevolute(1, 0.62, btVector3(0.0012, 0.0012, 0.0002), 0, aligned, btVector3(1, 0, 0),
                        btVector3(0, -0.004, -0.155), btVector3(0, 0.003, -0.118), true);
    body_.finalizeMultiDof();
    world_.addMultiBody(&body_);
    world_.setGravity(btVector3(0, 0, -9.81));
    world_.getSolverInfo().m_numIterations = iterations;
    world_.getSolverInfo().m_leastSquaresResidualThreshold = 1e-12;
    if (constraints) addConstraints();
    btScalar angle = 0.3;
    body_.setJointPosMultiDof(1, &angle);
  }

  ~BareWorld() {
    for (auto& constraint : constraints_) world_.removeMultiBodyConstraint(constraint.get());
    for (auto& collider : colliders_) world_.removeCollisionObject(collider.get());
    world_.removeMultiBody(&body_);
  }
  BareWorld(const BareWorld&) = delete;
  BareWorld& operator=(const BareWorld&) = delete;

  void step() { world_.stepSimulation(0.002, 0); }

 private:
  void addConstraints() {
    // Bullet ignores multibody constraints without link colliders.
    for (int link = 0; link < 2; ++link) {
      auto collider = std::make_unique<btMultiBodyLinkCollider>(&body_, link);
      collider->setCollisionShape(&shape_);
      world_.addCollisionObject(collider.get(), 0, 0);
      body_.getLink(link).m_collider = collider.get();
      colliders_.push_back(std::move(collider));
    }
    constraints_.push_back(std::make_unique<btMultiBodySphericalJointMotor>(&body_, 0, 0.05 * 0.002));
    constraints_.push_back(std::make_unique<btMultiBodyJointMotor>(&body_, 1, 0.0, 0.02 * 0.002));
    constraints_.push_back(std::make_unique<btMultiBodyJointLimitConstraint>(&body_, 1, 0.0, 2.3562));
    for (auto& constraint : constraints_) {
      world_.addMultiBodyConstraint(constraint.get());
      constraint->finalizeMultiDof();
    }
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btSimpleBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btMultiBody body_{2, 0.0, btVector3(0, 0, 0), true, false};
  btSphereShape shape_{0.02};
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
};

void BareBulletWithoutConstraints(benchmark::State& state) {
  BareWorld world(false, 10);
  for (auto _ : state) world.step();
}
BENCHMARK(BareBulletWithoutConstraints);

/// The peer of ArmStep. The argument is the solver's number of iterations: 10 is Bullet's default, 50 is what a joint
/// at its stop needs to settle.
void BareBulletWithLimitsAndFriction(benchmark::State& state) {
  BareWorld world(true, static_cast<int>(state.range(0)));
  for (auto _ : state) world.step();
}
BENCHMARK(BareBulletWithLimitsAndFriction)->Arg(10)->Arg(50);

/// Steps of a pose as the protocol runs it: moving and settling.
void ArmStep(benchmark::State& state) {
  const ArmModel model = sampleArm();
  const PoseSet set = samplePoses(model);
  BulletArm arm(model, {});
  constexpr int kStepsPerPose = 1225;  // the mean of these poses with early acquisition
  int steps = kStepsPerPose;
  std::size_t pose = 0;
  for (auto _ : state) {
    if (steps++ == kStepsPerPose) {
      state.PauseTiming();
      arm.reset();
      arm.setShaftReferences(set.poses[pose++ % set.poses.size()].shafts);
      steps = 0;
      state.ResumeTiming();
    }
    arm.step();
  }
}
BENCHMARK(ArmStep);

/// One pose by the protocol; the argument switches early acquisition.
void ReplayPose(benchmark::State& state) {
  const ArmModel model = sampleArm();
  const PoseSet set = samplePoses(model);
  PoseProtocol protocol;
  protocol.early_acquisition = state.range(0) != 0;
  BulletArm arm(model, protocol.arm);
  std::size_t pose = 0;
  double simulated = 0.0;
  for (auto _ : state) simulated += replayPose(arm, set.poses[pose++ % set.poses.size()].shafts, protocol).duration;
  state.counters["simulated_s_per_pose"] = simulated / static_cast<double>(state.iterations());
}
BENCHMARK(ReplayPose)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace simgap
