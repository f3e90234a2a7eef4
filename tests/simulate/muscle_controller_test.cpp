// Controllers on muscles of the sample arm and of the elbow rig.
#include "simgap/simulate/muscle_controller.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/simulate/rollout.h"
#include "simulate/controllers/state_space_force.h"
#include "support/arms.h"

namespace simgap {
namespace {

std::vector<double> timesTo(double end, double interval) {
  std::vector<double> times;
  for (int i = 0; i * interval < end + 1e-9; ++i) times.push_back(i * interval);
  return times;
}

// One cord between fixed points: nothing moves but the drive.
ArmModel bench() {
  ArmModel model = test::torso();
  model.bodies.push_back({"post", true, {}, {}});
  test::addLink(model, 0, JointType::kRevolute, {0.0, 0.0, 0.0}, {test::sphere(0.1, {0.0, 0.0, -0.1})});
  test::addMuscle(model, {0, {0.0, 0.0, 0.0}}, {1, {0.0, 0.0, 0.3}}, 0.3);
  return model;
}

MotionTrack play(const ArmModel& model, const MotionCommands& commands, double end, double interval = 0.002) {
  Rollout rollout(model, {});
  MotionTrack track;
  EXPECT_TRUE(rollout.run(commands, {}, timesTo(end, interval), track).finished);
  return track;
}

MotionCommands held(CommandKind kind, const ArmModel& model, double value) {
  MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), kind);
  commands.times = {0.0};
  commands.values = Eigen::MatrixXd::Constant(std::ssize(model.muscles), 1, value);
  return commands;
}

TEST(MuscleController, ForceArrivesAsSoonAsTheMotorCanWindAndStays) {
  const ArmModel model = bench();
  for (const double force : {5.0, 20.0, 60.0}) {
    const double winding = force / 900.0 / (14.8 * 0.006);  // [s] to stretch the cord at the no-load speed
    const MotionTrack track = play(model, held(CommandKind::kForce, model, force), 2.0);
    double highest = 0.0, late = 0.0;
    for (std::size_t row = 0; row < track.times.size(); ++row) {
      const double now = track.forces(0, static_cast<Eigen::Index>(row));
      highest = std::max(highest, now);
      if (track.times[row] > 0.1 + 1.2 * winding) late = std::max(late, std::abs(now - force));
    }
    EXPECT_LT(highest, 1.05 * force) << force;
    EXPECT_LT(late, 0.02 * force) << force;
  }
}

// Without Coulomb friction the loop is linear: with force and its model right, the poles are where they were asked to
// be, so that the slowest says how fast an error decays.
TEST(MuscleController, TheSlowestPoleIsTheOneAskedFor) {
  ArmModel model = bench();
  model.muscles[0].motor.coulomb_friction = model.muscles[0].gearbox.coulomb_friction = 0.0;
  RolloutOptions options;
  options.controllers.force_rates = {20.0, 200.0, 1500.0};
  Rollout rollout(model, options);
  MotionCommands commands = held(CommandKind::kForce, model, 10.0);
  commands.times = {0.0, 1.0};
  commands.values.resize(1, 2);
  commands.values << 10.0, 11.0;
  MotionTrack track;
  const std::vector<double> times = {1.0, 1.1, 1.15};
  ASSERT_TRUE(rollout.run(commands, {}, times, track).finished);
  EXPECT_NEAR(track.forces(0, 0), 10.0, 1e-3);
  const double decay = std::log((11.0 - track.forces(0, 1)) / (11.0 - track.forces(0, 2))) / 0.05;
  EXPECT_NEAR(decay, 20.0, 1.0);
}

TEST(MuscleController, OpenLoopVoltageIsTheMotorsOwn) {
  ArmModel model = bench();
  model.muscles[0].attachments[1].point.z() = 0.1;  // slack for long
  const MotionTrack track = play(model, held(CommandKind::kVoltage, model, 6.0), 0.5);
  Drive drive(model.muscles[0].motor, model.muscles[0].gearbox, 0.001);
  DriveState state;
  for (int i = 0; i < 500; ++i) drive.step(state, 6.0, 0.0);
  EXPECT_DOUBLE_EQ(track.shafts(0, track.shafts.cols() - 1), state.shaft_angle);
  EXPECT_EQ(track.voltages(0, 5), 6.0);
}

}  // namespace
}  // namespace simgap
