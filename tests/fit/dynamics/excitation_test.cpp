// Motions that `design --excite` finds: what they keep, and what they are worth, by the equations of tests/reality.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reality/robot_rig.h"
#include "simgap/core/error.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/dynamics/excitation.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const std::string kAll =
    "format: simgap/excitation-limits/1\nduration_s: 10\nharmonics: 4\nrate_Hz: 200\n"
    "all_joints: {velocity_rad_s: 1.5, acceleration_rad_s2: 6, velocity_m_s: 0.3, acceleration_m_s2: 1.2}\n";

ExcitationLimits limitsFrom(const std::string& yaml, const ArmModel& arm) {
  return ExcitationLimits::read(YamlNode::parse(yaml, "limits.yaml"), arm);
}

Excitation excite(const ArmModel& arm, const ExcitationLimits& limits, std::uint64_t seed = 1) {
  return exciteRobot(arm, friction::find("coulomb"), limits, seed, {});
}

TEST(Excitation, SeriesBeginAndEndAtRestAndTheirRatesAreTheirSlopes) {
  const ArmModel arm = test::drawnArm(reality::randomRobot(5, 3, false, true), 0);
  const ExcitationLimits limits = limitsFrom(kAll, arm);
  const FourierMotion motion = excite(arm, limits).motion;
  RobotMotion begin, end, before, now, after;
  motion.at(0.0, begin);
  motion.at(limits.duration, end);
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(begin.velocity[j], 0.0, 1e-12);
    EXPECT_NEAR(begin.acceleration[j], 0.0, 1e-11);
    EXPECT_NEAR(end.position[j], begin.position[j], 1e-12);
    EXPECT_NEAR(end.velocity[j], 0.0, 1e-12);
  }
  constexpr double kStep = 1e-5;
  for (double t = 0.3; t < limits.duration; t += 0.7) {
    motion.at(t - kStep, before);
    motion.at(t, now);
    motion.at(t + kStep, after);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(now.velocity[j], (after.position[j] - before.position[j]) / (2.0 * kStep), 1e-7);
      EXPECT_NEAR(now.acceleration[j], (after.velocity[j] - before.velocity[j]) / (2.0 * kStep), 1e-6);
    }
  }
}

/// At 2 kHz, by another's equations of motion.
void expectWithin(const reality::Robot& robot, const ArmModel& arm, const ExcitationLimits& limits,
                  const FourierMotion& motion) {
  const std::vector<std::size_t> links = test::linksOfJoints(arm);
  const Index n = std::ssize(robot.links);
  RobotMotion now;
  for (double t = 0.0; t < limits.duration; t += 5e-4) {
    motion.at(t, now);
    VectorXd q(n), v(n), a(n);
    for (std::size_t j = 0; j < links.size(); ++j) {
      const JointExcitationLimits& limit = limits.joints[j];
      ASSERT_GE(now.position[j], limit.lower);
      ASSERT_LE(now.position[j], limit.upper);
      ASSERT_LE(std::abs(now.velocity[j]), limit.velocity);
      ASSERT_LE(std::abs(now.acceleration[j]), limit.acceleration);
      const auto link = static_cast<Index>(links[j]);
      q[link] = now.position[j];
      v[link] = now.velocity[j];
      a[link] = now.acceleration[j];
    }
    const VectorXd torque = reality::rigidTorques(robot, q, v, a);
    for (std::size_t j = 0; j < links.size(); ++j) {
      ASSERT_LE(std::abs(torque[links[j]]), limits.joints[j].effort) << "joint " << j;
    }
  }
}

/// \param joints  of a robot, by its seed
void expectLimitsKept(int (*joints)(int seed)) {
  for (const int seed : {1, 2, 3}) {
    const reality::Robot robot =
        reality::randomRobot(static_cast<std::uint64_t>(seed), joints(seed), seed == 2, seed == 3);
    const ArmModel arm = test::drawnArm(robot, 0);
    ExcitationLimits limits = limitsFrom(kAll, arm);
    const Excitation free = excite(arm, limits);
    // A tenth less effort than the joints that need most of it would take.
    for (std::size_t j = 0; j < limits.joints.size(); ++j) limits.joints[j].effort = 0.9 * free.reached[j].effort;
    const Excitation bound = excite(arm, limits);
    expectWithin(robot, arm, limits, bound.motion);
    EXPECT_LE(free.precision.log_sd, bound.precision.log_sd) << "a limit cannot make a motion tell more";
  }
}

TEST(Excitation, KeepsTheLimitsOfMotionAndEffort) {
  expectLimitsKept([](int) { return 3; });
}

TEST(SlowExcitation, KeepsTheLimitsOfRobotsOfThreeToFiveJoints) {
  expectLimitsKept([](int seed) { return 2 + seed; });
}

/// A rod that hangs from a hinge: its end is off the axis by its length, whatever is searched.
TEST(Excitation, KeepsDistances) {
  reality::Robot pendulum;
  reality::RobotLink link;
  link.axis = Eigen::Vector3d::UnitX();
  link.centre = {0.0, 0.0, -0.3};
  link.inertia = 0.05 * Eigen::Matrix3d::Identity();
  pendulum.links = {link};
  const ArmModel arm = test::drawnArm(pendulum, 0);
  const std::string yaml =
      kAll +
      "distances:\n  - {body: link1, point_m: [0, 0, -0.5], at_least_m: 0.1, plane: {normal: [0, 1, "
      "0], at_m: -0.3}}\n";
  const Excitation found = excite(arm, limitsFrom(yaml, arm));
  // y of the end of a rod of 0.5 m at the angle q about x is 0.5 sin q.
  RobotMotion now;
  double lowest = INFINITY;
  for (double t = 0.0; t < 10.0; t += 1e-3) {
    found.motion.at(t, now);
    lowest = std::min(lowest, 0.5 * std::sin(now.position[0]));
  }
  EXPECT_GE(lowest, -0.2);
  EXPECT_NEAR(found.nearest.front(), lowest + 0.3, 1e-4);
  const Excitation free = excite(arm, limitsFrom(kAll, arm));
  EXPECT_LT(0.5 * std::sin(free.reached.front().lower), -0.2) << "the plane is no limit here";
}

TEST(Excitation, TheSameSeedGivesTheSameMotion) {
  const ArmModel arm = test::drawnArm(reality::randomRobot(5, 3, false, false), 0);
  const ExcitationLimits limits = limitsFrom(kAll, arm);
  const Excitation one = excite(arm, limits, 7), again = excite(arm, limits, 7), other = excite(arm, limits, 8);
  EXPECT_EQ(one.motion.cosines(), again.motion.cosines());
  EXPECT_EQ(one.motion.start(), again.motion.start());
  EXPECT_NE(one.motion.cosines(), other.motion.cosines());
}

TEST(Excitation, BadLimitsGetASentence) {
  const ArmModel arm = test::drawnArm(reality::randomRobot(5, 3, false, false), 0);
  const auto sentenceOf = [&](const std::string& yaml) -> std::string {
    try {
      excite(arm, limitsFrom(yaml, arm));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  const std::string head = "format: simgap/excitation-limits/1\n";
  EXPECT_NE(sentenceOf(head).find("joint j1: found no velocity_rad_s"), std::string::npos) << sentenceOf(head);
  EXPECT_NE(sentenceOf(kAll + "joints: {j9: {lower_rad: 0}}\n").find("found 'j9', expected joints of"),
            std::string::npos);
  EXPECT_NE(sentenceOf(kAll + "joints: {j1: {lower_rad: 1, upper_rad: 0.5}}\n").find("expected the lower one first"),
            std::string::npos);
  EXPECT_NE(sentenceOf(kAll + "payload: {body: arm}\n").find("found 'arm', expected a body"), std::string::npos);
  EXPECT_NE(sentenceOf(kAll + "joints: {j1: {torque_Nm: 1e-6}}\n").find("no motion of 10 s was found"),
            std::string::npos);
  EXPECT_NE(sentenceOf(kAll + "speed: 3\n").find("speed"), std::string::npos);
  // What one joint carries is felt as a moment about it, whatever the limits are: they are not to blame.
  const std::string first = sentenceOf(kAll + "payload: {body: " + arm.bodies[arm.joints[0].child].name + "}\n");
  EXPECT_NE(first.find("tells mass and centre of what"), std::string::npos) << first;
  std::string slow = kAll;
  slow.replace(slow.find("rad_s2: 6"), 9, "rad_s2: 1e-9");
  EXPECT_NE(sentenceOf(slow).find("tells the base parameters apart"), std::string::npos) << sentenceOf(slow);
}

/// What base parameters of a robot are off by, fitted to a motion of it: torques by Lagrange's equations, an encoder
/// and torque noise; shape (K).
VectorXd errorsAfter(const reality::Robot& robot, const ArmModel& arm, const FourierMotion& motion,
                     const std::vector<double>& noise, std::uint64_t seed) {
  const std::vector<std::size_t> links = test::linksOfJoints(arm);
  const Index n = std::ssize(robot.links);
  const CounterRandom random(seed);
  std::string csv = "time_s";
  for (Index j = 1; j <= n; ++j) csv += fmt::format(",j{0}_rad,j{0}_velocity_rad_s,torque_j{0}_Nm", j);
  RobotMotion now;
  for (std::uint32_t i = 0; i < 6000; ++i) {
    motion.at(0.01 * i, now);
    VectorXd q(n), v(n), a(n);
    for (std::size_t j = 0; j < links.size(); ++j) {
      const auto link = static_cast<Index>(links[j]);
      q[link] = now.position[j];
      v[link] = now.velocity[j];
      a[link] = now.acceleration[j];
    }
    const VectorXd rigid = reality::rigidTorques(robot, q, v, a);
    csv += fmt::format("\n{}", 0.01 * i);
    for (Index l = 0; l < n; ++l) {
      const reality::RobotLink& link = robot.links[l];
      const auto j = static_cast<std::size_t>(std::ranges::find(links, static_cast<std::size_t>(l)) - links.begin());
      const double drive = link.rotor * a[l] + link.viscous * v[l] + link.offset +
                           (v[l] > 0.0   ? link.coulomb
                            : v[l] < 0.0 ? -link.coulomb
                                         : 0.0);
      const double off = noise[j] * random.normalPair({i, static_cast<std::uint32_t>(l), 0, 1})[0];
      csv += fmt::format(",{},{},{}", 1e-5 * std::round(1e5 * q[l]), v[l], rigid[l] + drive + off);
    }
  }
  const RobotFit found = fitRobot(arm, test::robotLog(arm, csv + "\n"), {});
  const VectorXd truth = test::trueBase(robot, arm);
  VectorXd errors(truth.size());
  for (Index k = 0; k < truth.size(); ++k) errors[k] = found.fit.base[k].estimate.value - truth[k];
  return errors;
}

/// Fits to the motions that were found are better than fits to motions at random within the same limits, on hinges
/// only, by the geometric mean over all base parameters; \returns that ratio, and what was promised of the same
/// motions.
std::pair<double, double> gainOf(std::uint64_t seed) {
  reality::Robot robot = reality::randomRobot(seed, 2 + static_cast<int>(seed % 5), seed % 2 == 0, false);
  for (reality::RobotLink& link : robot.links) link.more_static = 0.0;
  const ArmModel arm = test::drawnArm(robot, 0);
  ExcitationLimits limits = limitsFrom(kAll, arm);
  limits.periods = 6;
  const Excitation first = excite(arm, limits);
  std::vector<double> noise;
  for (JointExcitationLimits& joint : limits.joints) {
    joint.noise = 0.02 * first.reached[&joint - limits.joints.data()].effort;
    noise.push_back(joint.noise);
  }
  const Excitation found = excite(arm, limits);
  constexpr int kRepeats = 4;
  VectorXd ours = VectorXd::Zero(found.precision.sd.size()), theirs = ours, promised = ours;
  for (std::uint64_t k = 0; k < kRepeats; ++k) {
    ours += errorsAfter(robot, arm, found.motion, noise, 100 * seed + k).cwiseAbs2();
    theirs += errorsAfter(robot, arm, found.drawn[k], noise, 100 * seed + k).cwiseAbs2();
    promised += found.random[k].sd.cwiseQuotient(found.precision.sd).cwiseAbs2();
  }
  const auto mean = [](const VectorXd& squares) { return std::exp(0.5 * squares.array().log().mean()); };
  return {mean(theirs.cwiseQuotient(ours)), mean(promised / kRepeats)};
}

void excitationStudy(std::uint64_t first, std::uint64_t robots) {
  std::vector<double> gains, promised;
  for (std::uint64_t seed = first; seed < first + robots; ++seed) {
    const auto [gain, promise] = gainOf(seed);
    gains.push_back(gain);
    promised.push_back(promise);
    fmt::print("robot {}: errors {:.2f} times as small as after motions at random, promised {:.2f}\n", seed, gain,
               promise);
  }
  fmt::print("median {:.2f}, smallest {:.2f}; promised {:.2f}\n", median(gains), *std::ranges::min_element(gains),
             median(promised));
  EXPECT_GT(median(gains), 1.3);
  EXPECT_NEAR(median(gains) / median(promised), 1.0, 0.25) << "promises are kept";
}

TEST(ExcitationStudy, ARobotIsLearnedBetterThanFromMotionsAtRandom) { excitationStudy(51, 1); }

TEST(SlowExcitationStudy, RobotsAreLearnedBetterThanFromMotionsAtRandom) { excitationStudy(1, 30); }

}  // namespace
}  // namespace simgap
