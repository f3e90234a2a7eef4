// The joint of two pneumatic muscles and a motor: its integrator against closed forms, its motions against a simulator
// that shares no code with it, its rest against the same muscles in an arm; the split of torques.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reality/exo_joint_rig.h"
#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/exo_joint_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

FittedModel noModel(const std::string& file) { throw ConfigError("asked for " + file); }

ExoJoint sampleJoint() { return readExoJoint(YamlNode::load(sourceFile("data/exoskeleton/joint.yaml")), noModel); }

/// The sample joint without its muscles' pressure, friction, weight and stops.
ExoJoint freeJoint() {
  ExoJoint joint = sampleJoint();
  joint.motor.reset();
  joint.link = {.inertia = 2.0, .lower = -1e3, .upper = 1e3};
  return joint;
}

ExoJointMotion playedFor(const ExoJoint& joint, double angle, const ExoJointMotion::Inputs& inputs, double seconds,
                         double step = 1e-3) {
  ExoJointMotion motion(joint);
  motion.reset(angle, {});
  for (int i = 0; i < std::lround(seconds / step); ++i) motion.step(inputs, step);
  return motion;
}

TEST(ExoJointMotion, AConstantTorqueAgainstViscousFriction) {
  ExoJoint joint = freeJoint();
  joint.link.viscous_friction = 1.5;
  const ExoJointMotion motion = playedFor(joint, 0.2, {.external = 3.0}, 2.0);
  const double rate = 1.5 / 2.0, last = 3.0 / 1.5, e = std::exp(-rate * 2.0);
  EXPECT_NEAR(motion.velocity(), last * (1.0 - e), 1e-10);
  EXPECT_NEAR(motion.angle(), 0.2 + last * (2.0 - (1.0 - e) / rate), 1e-10);
}

/// The period of a pendulum of any swing is 4 K(sin(swing / 2)) / omega_0.
TEST(ExoJointMotion, APendulumComesBackAfterItsPeriod) {
  ExoJoint joint = freeJoint();
  joint.link.weight = 30.0, joint.link.hangs_at = 0.4;
  const double swing = 1.2, period = 4.0 * std::comp_ellint_1(std::sin(0.5 * swing)) / std::sqrt(30.0 / 2.0);
  const int steps = 4000;
  const ExoJointMotion motion = playedFor(joint, 0.4 + swing, {}, period, period / steps);
  EXPECT_NEAR(motion.angle(), 0.4 + swing, 1e-9);
  EXPECT_NEAR(motion.velocity(), 0.0, 1e-8);
}

/// A first-order lag is exp(-t / T), and half the step leaves a sixteenth of the error.
TEST(ExoJointMotion, TheMethodIsOfFourthOrder) {
  ExoJoint joint = freeJoint();
  joint.link.inertia = 1e6;  // stands still
  const auto error = [&](double step) {
    const double pressure = playedFor(joint, 0.0, {.flexor_pressure = 1e5}, 0.08, step).state()[2];
    return std::abs(pressure - 1e5 * (1.0 - std::exp(-0.08 / joint.valve_time)));
  };
  EXPECT_NEAR(std::log2(error(0.008) / error(0.004)), 4.0, 0.2);
}

TEST(ExoJointMotion, ValvesFillExponentiallyUpToTheSupply) {
  ExoJoint joint = freeJoint();
  joint.link.inertia = 1e6;  // stands still
  const ExoJointMotion motion = playedFor(joint, 0.0, {.flexor_pressure = 9e5, .extensor_pressure = 1e5}, 0.1);
  const double filled = 1.0 - std::exp(-0.1 / joint.valve_time);
  EXPECT_NEAR(motion.state()[ExoJointMotion::kFlexorPressure], joint.supply * filled, 1.0);
  EXPECT_NEAR(motion.state()[ExoJointMotion::kExtensorPressure], 1e5 * filled, 1.0);
}

TEST(ExoJointMotion, StandsBeforeDryFrictionIsOvercomeAndAtItsStops) {
  ExoJoint joint = freeJoint();
  joint.link.coulomb_friction = 1.0;
  EXPECT_LT(std::abs(playedFor(joint, 0.0, {.external = 0.5}, 3.0, 1e-4).angle()), 0.005);
  EXPECT_GT(playedFor(joint, 0.0, {.external = 1.2}, 3.0, 1e-4).angle(), 0.2);
  joint.link.upper = 0.3;
  joint.link.lower = -0.3;
  EXPECT_NEAR(playedFor(joint, 0.0, {.external = 20.0}, 4.0, 1e-4).angle(), 0.3, 0.001);
}

/// Braid by virtual work, tendon by bisection, another integrator.
TEST(ExoJointMotion, MovesAsAnIndependentSimulatorSays) {
  const ExoJoint joint = sampleJoint();
  const auto inputs = [](double t) -> std::array<double, 4> {
    return {3e5 + 2e5 * std::sin(2.0 * t), 2e5 + 1.5e5 * std::sin(1.3 * t + 1.0), 4.0 * std::sin(5.0 * t),
            5.0 * std::sin(0.7 * t)};
  };
  const double step = 1e-4;
  const reality::ExoRigRecord rig = reality::recordExoRig({}, inputs, 3.0, 100.0, step);
  ExoJointMotion motion(joint);
  motion.reset(0.0, {});
  double farthest = 0.0;
  for (std::size_t i = 0; i < rig.time.size(); ++i) {
    EXPECT_NEAR(motion.angle(), rig.angle[i], 5e-4) << "at " << rig.time[i];  // its steps are of first order
    EXPECT_NEAR(motion.muscleTorque(), rig.torque[i], 0.1) << "at " << rig.time[i];
    farthest = std::max(farthest, std::abs(rig.angle[i]));
    for (int k = 0; k < 100; ++k) {
      const auto [flexor, extensor, current, external] = inputs(rig.time[i] + k * step);
      motion.step({flexor, extensor, current, external}, step);
    }
  }
  EXPECT_GT(farthest, 0.1);
}

/// The same muscles as lines of an arm, over wheels on a hinge.
TEST(ExoJointMotion, RestsWhereAnArmOfTheSameMusclesRests) {
  ExoJoint joint = sampleJoint();
  joint.hysteresis = 0.0;
  joint.link.coulomb_friction = joint.motor->coulomb_friction = 0.0;
  const ArmModel arm = readArm(YamlNode::load(sourceFile("data/exoskeleton/arm.yaml")));
  EquilibriumArm equilibrium(arm);
  for (const auto& [flexor, extensor, current] :
       {std::array{4e5, 1e5, 0.0}, std::array{1e5, 5e5, 3.0}, std::array{6e5, 6e5, -5.0}}) {
    ASSERT_TRUE(equilibrium.solve(std::vector{flexor, extensor, current}).stable);
    const ExoJointMotion motion = playedFor(joint, 0.0, {flexor, extensor, current, 0.0}, 12.0);
    EXPECT_NEAR(motion.angle(), equilibrium.joints()[0].angle, 1e-4) << flexor;
  }
}

TEST(AntagonistJoint, TorqueAndStiffnessAreThoseOfTheBraid) {
  const AntagonistJoint joint = sampleJoint().muscles;
  const reality::ExoRig rig;
  const auto torque = [&](double flexor, double extensor, double angle) {
    const double e = rig.radius * angle / rig.length;
    return rig.radius *
           (reality::exoMuscleForce(rig, flexor, rig.rest + e) - reality::exoMuscleForce(rig, extensor, rig.rest - e));
  };
  for (const double angle : {-0.8, -0.2, 0.0, 0.5}) {
    for (const auto& [flexor, extensor] : {std::pair{6e5, 6e5}, std::pair{1e5, 4e5}, std::pair{5e5, 0.0}}) {
      EXPECT_NEAR(joint.torque(flexor, extensor, angle), torque(flexor, extensor, angle), 1e-4);
      const double stiffness =
          -(torque(flexor, extensor, angle + 1e-3) - torque(flexor, extensor, angle - 1e-3)) / 2e-3;
      EXPECT_NEAR(joint.stiffness(flexor, extensor, angle), stiffness, 1e-3 * stiffness + 1e-3);
    }
  }
}

TEST(TorqueSplit, PressuresGiveTheTorqueWhereTheyCan) {
  const AntagonistJoint joint = sampleJoint().muscles;
  const reality::ExoRig rig;
  const TorqueSplit split(joint, {.highest_pressure = 6e5, .co_contraction = {CoContraction::Kind::kForce, 200.0}});
  for (const double angle : {-0.5, 0.0, 0.6}) {
    for (const double torque : {-20.0, -1.0, 0.0, 7.0, 25.0}) {
      const TorqueShares shares = split.pressuresFor(torque, angle);
      const double e = rig.radius * angle / rig.length;
      const double pull = reality::exoMuscleForce(rig, shares.flexor_pressure, rig.rest + e);
      const double back = reality::exoMuscleForce(rig, shares.extensor_pressure, rig.rest - e);
      EXPECT_NEAR(rig.radius * (pull - back), torque, 1e-3);
      EXPECT_NEAR(std::min(pull, back), 200.0, 0.1);
      EXPECT_NEAR(shares.muscles, torque, 1e-9);
    }
  }
}

TEST(TorqueSplit, MakesTheJointAsStiffAsItIsAsked) {
  const AntagonistJoint joint = sampleJoint().muscles;
  const TorqueSplit split(joint, {.highest_pressure = 6e5, .co_contraction = {CoContraction::Kind::kStiffness, 60.0}});
  for (const double torque : {-15.0, 0.0, 15.0}) {
    const TorqueShares shares = split.pressuresFor(torque, 0.1);
    EXPECT_NEAR(joint.stiffness(shares.flexor_pressure, shares.extensor_pressure, 0.1), 60.0, 0.01);
    EXPECT_NEAR(joint.torque(shares.flexor_pressure, shares.extensor_pressure, 0.1), torque, 1e-6);
  }
}

/// At the supply's limit co-contraction goes first, then the motor comes, then torque is missing.
TEST(TorqueSplit, GivesTheRestToTheMotorAndSaysWhatIsMissing) {
  const AntagonistJoint joint = sampleJoint().muscles;
  const double most = joint.torque(6e5, 0.0, 0.0);
  TorqueSplit split(
      joint, {.highest_pressure = 6e5, .motor_limit = 9.0, .co_contraction = {CoContraction::Kind::kForce, 500.0}});
  const TorqueShares inside = split.update(most - 1.0, 0.0, most - 1.0, 0.01);
  EXPECT_EQ(inside.flexor_pressure, 6e5);
  EXPECT_NEAR(inside.muscles, most - 1.0, 1e-9);  // of 20 N m co-contraction 1 is left
  EXPECT_NEAR(inside.motor, 0.0, 1e-9);
  const TorqueShares above = split.update(most + 6.0, 0.0, most, 0.01);
  EXPECT_EQ(above.extensor_pressure, 0.0);
  EXPECT_NEAR(above.motor, 6.0, 1e-9);
  EXPECT_NEAR(above.missing, 0.0, 1e-9);
  const TorqueShares beyond = split.update(most + 20.0, 0.0, most, 0.01);
  EXPECT_NEAR(beyond.motor, 9.0, 1e-12);
  EXPECT_NEAR(beyond.missing, 11.0, 1e-9);
}

/// What is faster than the crossover is left to the motor: a sine at the crossover reaches the muscles 3 dB smaller.
TEST(TorqueSplit, LeavesHighFrequenciesToTheMotor) {
  const AntagonistJoint joint = sampleJoint().muscles;
  const auto amplitude = [&](double frequency) {
    TorqueSplit split(joint, {.highest_pressure = 6e5, .motor_limit = 9.0, .crossover = 2.0});
    double largest = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const double t = i * 1e-3;
      const double muscles =
          split.update(10.0 * std::sin(2.0 * std::numbers::pi * frequency * t), 0.0, 0.0, 1e-3).muscles;
      if (t > 10.0) largest = std::max(largest, std::abs(muscles));
    }
    return largest / 10.0;
  };
  EXPECT_NEAR(amplitude(2.0), 1.0 / std::sqrt(2.0), 0.01);
  EXPECT_NEAR(amplitude(20.0), 0.1, 0.01);
  EXPECT_NEAR(amplitude(0.2), 1.0, 0.01);
}

/// 002 fig. 8: with the tendons in the controller the muscles alone follow, without them they do not.
TEST(ExoJointStudy, TendonsInTheControllerImproveItsTorque) {
  const ExoJoint joint = sampleJoint();
  const ExoJointCommands commands =
      readExoJointSchedule(joint, YamlNode::load(sourceFile("data/exoskeleton/torque.yaml")));
  const ExoJointStudy study = studyExoJoint(joint, commands, 20.0, 2e-4);
  ASSERT_EQ(study.runs.size(), 4U);
  EXPECT_EQ(study.runs[1].name, "tendon_alone");
  EXPECT_EQ(study.runs[3].name, "rigid_alone");
  EXPECT_LT(study.runs[1].tracking.rms, 0.3 * study.runs[3].tracking.rms);
  EXPECT_LT(study.runs[0].tracking.rms, 0.2 * study.runs[1].tracking.rms);  // the motor covers what is left
  EXPECT_LT(study.half_step, 1e-4);
}

/// A step beyond the controller's tick is the tick, and half of it is half of what was taken.
TEST(ExoJointStudy, SaysWhichStepItTook) {
  const ExoJoint joint = sampleJoint();
  const ExoJointCommands commands =
      readExoJointSchedule(joint, YamlNode::load(sourceFile("data/exoskeleton/torque.yaml")));
  const ExoJointStudy study = studyExoJoint(joint, commands, 2.0, 0.5);
  EXPECT_NEAR(study.main().play.step, 1.0 / joint.rate, 1e-12);
  EXPECT_GT(study.half_step, 0.0);
}

/// Of the tendons' share nothing is left where there is no friction, and the joint moves slowly.
TEST(ExoJointStudy, WithoutHysteresisTheRestIsTheValvesLag) {
  ExoJoint joint = sampleJoint();
  joint.hysteresis = 0.0;
  joint.valve_time = 1e-3;
  const ExoJointCommands commands =
      readExoJointSchedule(joint, YamlNode::load(sourceFile("data/exoskeleton/torque.yaml")));
  EXPECT_LT(studyExoJoint(joint, commands, 10.0, 2e-4).runs[1].tracking.rms, 0.05);
}

// The supply's 6 bar make the joint as stiff as 100 Nm/rad; what was asked for was not named.
TEST(ExoJointStudy, SaysWhatTheMusclesDoNotReach) {
  using Kind = CoContraction::Kind;
  ExoJoint joint = sampleJoint();
  const ExoJointCommands commands =
      readExoJointSchedule(joint, YamlNode::load(sourceFile("data/exoskeleton/torque.yaml")));
  const auto notes = [&](CoContraction asked) {
    joint.co_contraction = asked;
    return fmt::format("{}", fmt::join(studyExoJoint(joint, commands, 5.0, 1e-3).notes, "; "));
  };
  EXPECT_THAT(notes({Kind::kStiffness, 5000.0}), HasSubstr("did not give the stiffness of 5e+03 Nm/rad for 100.0 %"));
  EXPECT_THAT(notes({Kind::kForce, 5000.0}), HasSubstr("did not give the co-contraction of 5e+03 N for 100.0 %"));
  for (const CoContraction within : {CoContraction{Kind::kStiffness, 40.0}, CoContraction{Kind::kForce, 100.0}}) {
    EXPECT_THAT(notes(within), Not(HasSubstr("did not give"))) << within.value;
  }
}

std::string jointText() { return readText(sourceFile("data/exoskeleton/joint.yaml")); }
std::string exoJointError(const std::string& text) {
  return errorOf([&] { readExoJoint(YamlNode::parse(text, "joint.yaml"), noModel); });
}

/// Between the two torques an exponential, from the tick on at which the switch turns.
TEST(ExoJointCommands, ASwitchTurnsWithALag) {
  ExoJoint joint = sampleJoint();
  joint.by_switch = ExoSwitch{.up = 6.0, .down = -2.0, .rise_time = 0.5};
  const ExoJointCommands commands = switchedTorques(joint, {{0.0, 1.0, 3.0}, {false, true, false}}, 4.0);
  const auto torque = [&](double time) {
    return commands.over_time.values(0, static_cast<Eigen::Index>(std::lround(time * joint.rate)));
  };
  ASSERT_EQ(commands.over_time.times.size(), 2001U);
  EXPECT_EQ(torque(0.998), -2.0);
  const double tick = 1.0 / joint.rate;
  EXPECT_NEAR(torque(1.5), 6.0 - 8.0 * std::exp(-(0.5 + tick) / 0.5), 1e-9);
  EXPECT_NEAR(torque(4.0), -2.0 + 8.0 * std::exp(-(1.0 + tick) / 0.5) * (1.0 - std::exp(-2.0 / 0.5)), 1e-9);
}

TEST(ExoJointFile, RefusesWhatNoJointIs) {
  const auto with = [](const std::string& from, const std::string& to) { return replaced(jointText(), from, to); };
  EXPECT_THAT(exoJointError(with("lower_limit_deg: -55", "lower_limit_deg: 60")),
              HasSubstr("expected lower_limit_rad below upper_limit_rad"));
  EXPECT_THAT(exoJointError(with("upper_limit_deg: 55", "upper_limit_deg: 400")),
              HasSubstr("at the joint's limits the flexor contracts by"));
  EXPECT_THAT(exoJointError(with("braid_angle_deg: 25", "braid_angle_deg: 70")),
              HasSubstr("expected an angle between"));
  EXPECT_THAT(
      exoJointError(with("{diameter_mm: 30, braid_angle_deg: 25, k_N", "{a_m2: 0.01, b_m2: 0.02, c_m2: 0.005, k_N")),
      HasSubstr("a force that does not fall to 0"));
  EXPECT_THAT(exoJointError(with("extensor_pressure_MPa: 0.6", "extensor_pressure_MPa: 0.6, co_contraction_N: 3")),
              HasSubstr("found two of co_contraction_N"));
  EXPECT_THAT(exoJointError(with("supply_MPa: 0.6", "supply_MPa: 0")), HasSubstr("supply_MPa"));
  EXPECT_THAT(exoJointError(with("extensor_pressure_MPa: 0.6", "extensor_pressure_MPa: 0.9")),
              HasSubstr("found an extensor_pressure of 9e+05 Pa, expected at most the supply's 6e+05 Pa"));
  EXPECT_THAT(exoJointError(with("ratio: 20", "ration: 20")), HasSubstr("ratio"));
  EXPECT_THAT(exoJointError(with("{diameter_mm: 30, braid_angle_deg: 25, k_N: 40000,", "{model: m.yaml,")),
              HasSubstr("asked for m.yaml"));
}

TEST(ExoJointCommands, AreTorquesOrPressures) {
  const ExoJoint joint = sampleJoint();
  const auto read = [&](const std::string& text) {
    return readExoJointCommands(joint, CsvTable::parse(text, "commands.csv"), false);
  };
  EXPECT_TRUE(read("time_s,torque_Nm\n0,1\n1,2\n").torque);
  const ExoJointCommands commands =
      read("time_s,pressure_flexor_bar,pressure_extensor_bar,external_torque_Nm\n0,1,2,3\n1,2,3,4\n");
  EXPECT_FALSE(commands.torque);
  EXPECT_EQ(commands.over_time.values(0, 1), 2e5);
  EXPECT_EQ(commands.over_time.values(2, 1), 0.0);  // no current
  EXPECT_EQ(commands.over_time.values(3, 1), 4.0);
  EXPECT_THAT(errorOf([&] { read("time_s,angle_rad\n0,1\n"); }),
              HasSubstr("expected torque_Nm, or pressure_flexor_Pa"));
  EXPECT_THAT(errorOf([&] { read("time_s,pressure_flexor_Pa,pressure_extensor_Pa\n0,-1,2\n"); }),
              HasSubstr("commands.csv:2: found a pressure_flexor of -1 Pa"));
  EXPECT_THAT(errorOf([&] { read("time_s,torque_Nm\n1,1\n0,2\n"); }), HasSubstr("expected rising times"));
}

}  // namespace
}  // namespace simgap::test
