// What `diagnose` says of a robot's log: causes hidden in robots whose torques come from Lagrange's equations.
#include <gtest/gtest.h>

#include <cmath>

#include "diagnose/robots/robot_cases.h"
#include "diagnose/surrogates.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

class RobotDiagnosisTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { drawn_ = new test::RobotCase(test::drawCase(1004, 3, test::shortRig(30.0))); }
  static void TearDownTestSuite() {
    delete drawn_;
    drawn_ = nullptr;
  }
  static RobotDiagnosis diagnosed(const reality::Robot& truth) {
    return test::diagnoseCase(*drawn_, truth, test::shortRig(30.0), 77);
  }
  static RobotDiagnosis diagnosed(const reality::Robot& truth, const RobotDiagnosisOptions& options) {
    const std::string csv = reality::recordRobot(truth, test::shortRig(30.0), 77);
    return diagnoseRobot(drawn_->known, test::robotLog(drawn_->arm, csv), options, {});
  }
  static inline test::RobotCase* drawn_ = nullptr;
};

const Estimate& parameterOf(const Cause& cause, const std::string& name) {
  return *std::ranges::find(cause.parameters, name, &Estimate::name);
}

TEST_F(RobotDiagnosisTest, NothingHiddenIsNothingFound) {
  const RobotDiagnosis found = diagnosed(drawn_->robot);
  EXPECT_EQ(found.diagnosis.verdict, DiagnosisVerdict::kNothingFound) << found.diagnosis.sentence;
  EXPECT_TRUE(found.diagnosis.causes.empty());
  ASSERT_EQ(found.joints.size(), 3u);
  for (const JointVerdict& joint : found.joints) {
    EXPECT_LT(joint.after, 0.1) << joint.joint;
    EXPECT_NEAR(joint.times_known, 1.0, 0.5) << joint.joint;
  }
}

/// A robot that is as it was, with a sensor that drifts about: no cause, but no robot of which nothing is missing
/// either.
TEST_F(RobotDiagnosisTest, AnErrorBeyondTheKnownOneIsNotSilent) {
  reality::RobotRigOptions noisy = test::shortRig(30.0);
  noisy.torque_noise *= 3.0;
  noisy.correlation = 0.97;
  const RobotDiagnosis found = test::diagnoseCase(*drawn_, drawn_->robot, noisy, 77);
  EXPECT_EQ(found.diagnosis.verdict, DiagnosisVerdict::kUnexplained) << found.diagnosis.sentence;
  EXPECT_NE(found.diagnosis.sentence.find("Beyond the squared error of the log in which the robot was found: j1 ("),
            std::string::npos)
      << found.diagnosis.sentence;
  EXPECT_EQ(found.diagnosis.next_experiment.find("Nothing is missing"), std::string::npos);
  // Nine times, but for how much more or less torque this motion asks for: the noise is a part of that.
  for (const JointVerdict& joint : found.joints) {
    EXPECT_GT(joint.times_known, 3.0) << joint.joint;
    EXPECT_LT(joint.times_known, 20.0) << joint.joint;
  }
}

/// More noise from row to row is no cause that anything could find.
TEST_F(RobotDiagnosisTest, MoreNoiseFromRowToRowIsNothing) {
  reality::RobotRigOptions noisy = test::shortRig(30.0);
  noisy.torque_noise *= 3.0;
  noisy.correlation = 0.0;
  const RobotDiagnosis found = test::diagnoseCase(*drawn_, drawn_->robot, noisy, 77);
  EXPECT_EQ(found.diagnosis.verdict, DiagnosisVerdict::kNothingFound) << found.diagnosis.sentence;
  for (const JointVerdict& joint : found.joints) EXPECT_LT(joint.times_known, 1.5) << joint.joint;
}

TEST_F(RobotDiagnosisTest, WhatIsLeftOfOtherJointsIsSaidOfThem) {
  reality::Robot truth = drawn_->robot;
  truth.links[0].effort_gain = 1.3;
  truth.links[2].ripple = 0.5 * truth.links[2].coulomb;
  truth.links[2].ripple_ratio = 4.0;
  RobotDiagnosisOptions options;
  options.effects = {"torque-constant"};
  const RobotDiagnosis found = diagnosed(truth, options);
  ASSERT_EQ(found.diagnosis.causes.size(), 1u) << found.diagnosis.sentence;
  ASSERT_EQ(found.elsewhere.size(), 1u) << found.diagnosis.sentence;
  EXPECT_EQ(found.elsewhere[0].joint, "j3");
  EXPECT_EQ(found.elsewhere[0].channels[0].channel, "position of j3");
  EXPECT_NE(
      found.diagnosis.sentence.find("of the squared error of j3, on which no named cause acts, by position of j3"),
      std::string::npos)
      << found.diagnosis.sentence;
}

/// It was a payload below nothing, with a base that leans: a constant pull upwards is most of what a cord does.
TEST_F(RobotDiagnosisTest, ACordThatPullsAtTheHandHasNoName) {
  for (const double stiffness : {8.0, 25.0}) {
    reality::Robot truth = drawn_->robot;
    truth.cord.stiffness = stiffness;
    const Diagnosis d = diagnosed(truth).diagnosis;
    EXPECT_EQ(d.verdict, DiagnosisVerdict::kUnexplained) << stiffness << " N/m: " << d.sentence;
    EXPECT_TRUE(d.causes.empty()) << d.sentence;
  }
}

/// With several numbers changed and none of them asked for, no motion of one joint would tell what it is.
TEST_F(RobotDiagnosisTest, WhatAllNumbersSaveHasWordsOfItsOwn) {
  reality::Robot truth = drawn_->robot;
  for (reality::RobotLink& link : truth.links) {
    link.mass *= 1.2;
    link.coulomb *= 0.8;
    link.rotor *= 1.3;
  }
  RobotDiagnosisOptions options;
  options.effects = {"channel-delay"};
  const Diagnosis d = diagnosed(truth, options).diagnosis;
  ASSERT_EQ(d.verdict, DiagnosisVerdict::kUnexplained) << d.sentence;
  EXPECT_NE(d.sentence.find("by all numbers of its bodies and drives, most at j"), std::string::npos) << d.sentence;
  EXPECT_NE(d.next_experiment.find("find the robot from this log, too"), std::string::npos) << d.next_experiment;
}

/// Mass and place of a weight that hangs on the last link, and the robot that holds it.
TEST_F(RobotDiagnosisTest, APayloadIsWeighedAndPlaced) {
  reality::Robot truth = drawn_->robot;
  reality::RobotLink& link = truth.links[2];
  const Eigen::Vector3d point(0.05, -0.1, 0.12);
  const double mass = 1.2, whole = link.mass + mass;
  const Eigen::Vector3d centre = (link.mass * link.centre + mass * point) / whole;
  for (const auto& [m, at] : {std::pair(link.mass, link.centre), std::pair(mass, point)}) {
    const Eigen::Vector3d r = at - centre;
    link.inertia += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  link.mass = whole;
  link.centre = centre;
  const RobotDiagnosis found = diagnosed(truth);
  ASSERT_EQ(found.diagnosis.causes.size(), 1u) << found.diagnosis.sentence;
  const Cause& cause = found.diagnosis.causes.front();
  EXPECT_EQ(test::labelOf(cause), "payload:link3");
  const Estimate& weighed = parameterOf(cause, "mass");
  EXPECT_LE(weighed.lower95, mass);
  EXPECT_GE(weighed.upper95, mass);
  EXPECT_LT(weighed.upper95 - weighed.lower95, 0.5 * mass);
  ASSERT_TRUE(found.extended.has_value());
  const RobotLog log = test::robotLog(drawn_->arm, reality::recordRobot(truth, test::shortRig(20.0), 78));
  const Eigen::MatrixXd before = predictEfforts(drawn_->known, log), after = predictEfforts(*found.extended, log);
  double gained = 1.0;
  for (std::size_t c = 0; c < 3; ++c)
    gained = std::min(gained, relativeError(log, c, after) / relativeError(log, c, before));
  EXPECT_LT(gained, 0.7);  // on another motion, by the file that was written
}

/// The spectrum's peak is coarse; the period is a number of the cause, with an interval.
TEST_F(RobotDiagnosisTest, TheRatioOfARippleIsFitted) {
  reality::Robot truth = drawn_->robot;
  truth.links[1].ripple = 0.4 * truth.links[1].coulomb;
  truth.links[1].ripple_ratio = 11.37;
  const RobotDiagnosis found = diagnosed(truth);
  ASSERT_EQ(found.diagnosis.causes.size(), 1u) << found.diagnosis.sentence;
  const Cause& cause = found.diagnosis.causes.front();
  EXPECT_EQ(test::labelOf(cause), "position-ripple:j2");
  ASSERT_EQ(cause.parameters.size(), 3u);
  const Estimate& ratio = parameterOf(cause, "r");
  EXPECT_LE(ratio.lower95, 11.37);
  EXPECT_GE(ratio.upper95, 11.37);
  EXPECT_LT(ratio.upper95 - ratio.lower95, 0.3);
  const double size = std::hypot(parameterOf(cause, "a").value, parameterOf(cause, "b").value);
  EXPECT_NEAR(size, truth.links[1].ripple, 0.15 * truth.links[1].ripple);
}

TEST_F(RobotDiagnosisTest, ARotorOfAnotherDriveIsNamedWithItsJoint) {
  reality::Robot truth = drawn_->robot;
  truth.links[1].rotor += 0.8;
  const RobotDiagnosis found = diagnosed(truth);
  EXPECT_EQ(test::answerFor(found.diagnosis, "rotor-inertia:j2"), "right") << found.diagnosis.sentence;
}

TEST_F(RobotDiagnosisTest, AHoseAtAJointIsNamedWithItsStiffness) {
  reality::Robot truth = drawn_->robot;
  const double stiffness = 2.0 * truth.links[1].coulomb;
  truth.links[1].spring = stiffness;
  truth.links[1].spring_rest = 0.4;
  const RobotDiagnosis found = diagnosed(truth);
  ASSERT_EQ(test::answerFor(found.diagnosis, "joint-spring:j2"), "right") << found.diagnosis.sentence;
  EXPECT_NEAR(parameterOf(found.diagnosis.causes.front(), "k").value, stiffness, 0.1 * stiffness);
  ASSERT_TRUE(found.extended.has_value());
  EXPECT_GT(found.extended->arm.joints.back().spring_stiffness + found.extended->arm.joints[1].spring_stiffness, 0.0);
}

/// An encoder behind a filter: by the joint's own effort alone that is less viscous friction, or an early effort.
TEST_F(RobotDiagnosisTest, ALatePositionIsNamedWithItsDelay) {
  reality::Robot truth = drawn_->robot;
  truth.links[1].position_late = 0.025;
  const Diagnosis d = diagnosed(truth).diagnosis;
  ASSERT_EQ(test::answerFor(d, "position-delay:j2"), "right") << d.sentence;
  EXPECT_NEAR(parameterOf(d.causes.front(), "dt").value, 0.025, 0.003);
}

/// Longer than the rows beside a turn that do not count, and known to a row (10 ms) and no better.
TEST_F(RobotDiagnosisTest, TheIntervalOfALongDelayHoldsIt) {
  reality::Robot effort = drawn_->robot, position = drawn_->robot;
  effort.links[1].effort_late = position.links[1].position_late = 0.06;
  for (const reality::Robot& truth : {effort, position}) {
    const Diagnosis d = diagnosed(truth).diagnosis;
    ASSERT_EQ(d.causes.size(), 1u) << d.sentence;
    const Estimate& delay = parameterOf(d.causes.front(), "dt");
    EXPECT_LT(delay.lower95, 0.06) << d.sentence;
    EXPECT_GT(delay.upper95, 0.06) << d.sentence;
    EXPECT_LT(delay.upper95 - delay.lower95, 0.015) << d.sentence;
  }
}

/// What a late position says of its own joint an early effort says, too: neither takes the other's name, nor a clock's.
TEST_F(RobotDiagnosisTest, ALateEffortAndALateClockAreNoLatePosition) {
  reality::Robot effort = drawn_->robot, clock = drawn_->robot, early = drawn_->robot;
  effort.links[1].effort_late = 0.025;
  clock.links[1].clock_late = 0.05;
  early.links[1].effort_late = -0.025;
  for (const auto& [truth, label] : {std::pair(effort, "channel-delay:j2"), std::pair(early, "channel-delay:j2"),
                                     std::pair(clock, "clock-offset:j2")}) {
    const Diagnosis d = diagnosed(truth).diagnosis;
    EXPECT_EQ(test::answerFor(d, label), "right") << label << ": " << d.sentence;
  }
}

/// What the drive's sensor shows is asked for: friction that thins by as much per degree, neither of the forms exactly.
TEST_F(RobotDiagnosisTest, FrictionThatThinsAsTheDriveWarmsUpIsNamed) {
  reality::Robot truth = drawn_->robot;
  truth.links[1].thins = 0.5;
  const Diagnosis d = diagnosed(truth).diagnosis;
  const auto heats = [](const Cause& cause) { return cause.effect == "friction-heating" && cause.target == "j2"; };
  const auto heating = std::ranges::find_if(d.causes, heats);
  ASSERT_NE(heating, d.causes.end()) << d.sentence;
  EXPECT_GT(parameterOf(*heating, "beta_dry").lower95, 0.0);
  EXPECT_NE(heating->sentence.find("T_mean = "), std::string::npos) << heating->sentence;
  for (const Cause& cause : d.causes) EXPECT_EQ(cause.target, "j2") << d.sentence;  // that log is warmer than the known
}

/// What a gripper picks up and puts down again is weighed, and no mass of all the log.
TEST_F(RobotDiagnosisTest, ALoadThatIsPickedUpIsNamedWithItsTime) {
  reality::Robot truth = drawn_->robot;
  truth.load = {0.6, {0.05, 0.0, 0.1}, 9.0, 21.0};
  const Diagnosis d = diagnosed(truth).diagnosis;
  ASSERT_EQ(test::answerFor(d, "payload-change:link3"), "right") << d.sentence;
  EXPECT_NEAR(parameterOf(d.causes.front(), "mass").value, 0.6, 0.05);
  EXPECT_NE(d.causes.front().sentence.find("it carries it in 4"), std::string::npos) << d.causes.front().sentence;
  EXPECT_NE(d.causes.front().sentence.find("first from "), std::string::npos) << d.causes.front().sentence;
}

/// The bodies carry what a joint does to others: a name that leaves it there only stands in for what has none.
TEST_F(RobotDiagnosisTest, AGearThatGivesHasNoName) {
  for (const double gives : {0.002, 0.006}) {
    reality::Robot truth = drawn_->robot;
    truth.links[1].gives = gives;
    const Diagnosis d = diagnosed(truth).diagnosis;
    EXPECT_EQ(d.verdict, DiagnosisVerdict::kUnexplained) << gives << ": " << d.sentence;
    EXPECT_TRUE(d.causes.empty()) << gives << ": " << d.sentence;
  }
}

/// A constant effort is an offset of the sensor or dry friction that differs by direction: no log of such a law tells.
TEST_F(RobotDiagnosisTest, AnExactAliasIsNamedBesideTheCause) {
  reality::Robot truth = drawn_->robot;
  truth.links[0].bias = 0.6 * truth.links[0].coulomb;
  const RobotDiagnosis found = diagnosed(truth);
  ASSERT_EQ(found.diagnosis.causes.size(), 1u) << found.diagnosis.sentence;
  EXPECT_EQ(found.diagnosis.verdict, DiagnosisVerdict::kAmbiguous);
  EXPECT_EQ(test::answerFor(found.diagnosis, "current-bias:j1"), "grouped") << found.diagnosis.sentence;
}

/// Of a robot whose bodies are fitted to the very log a payload cannot be told, and that is said.
TEST_F(RobotDiagnosisTest, WithoutAKnownRobotAPayloadIsNotTestable) {
  const RobotModel raw = robotModelOf(drawn_->arm);
  const RobotLog log = test::robotLog(drawn_->arm, reality::recordRobot(drawn_->robot, test::shortRig(30.0), 79));
  const Diagnosis d = diagnoseRobot(raw, log, {}, {}).diagnosis;
  EXPECT_TRUE(d.causes.empty()) << d.sentence;
  for (const char* name : {"payload", "link-inertia", "rotor-inertia", "coulomb-offset", "current-bias"}) {
    EXPECT_NE(std::ranges::find(d.not_testable, name, &NotTestable::effect), d.not_testable.end()) << name;
  }
}

TEST_F(RobotDiagnosisTest, AnEffortOfTheWrongSignIsAFaultOfTheData) {
  reality::Robot truth = drawn_->robot;
  truth.links[2].effort_gain = -1.0;
  const Diagnosis d = diagnosed(truth).diagnosis;
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kDataFault);
  ASSERT_EQ(d.faults.size(), 1u);
  EXPECT_EQ(d.faults.front().channel, "effort of j3");
}

TEST_F(RobotDiagnosisTest, TheLogOfAnotherRobotIsRefused) {
  const reality::Robot other = reality::randomRobot(55, 3, false, false);
  EXPECT_THROW(diagnosed(other), DataError);
}

TEST_F(RobotDiagnosisTest, TooShortALogIsRefused) {
  reality::RobotRigOptions rig = test::shortRig(3.0);
  rig.stops = false;
  const RobotLog log = test::robotLog(drawn_->arm, reality::recordRobot(drawn_->robot, rig, 80));
  EXPECT_THROW(diagnoseRobot(drawn_->known, log, {}, {}), DataError);
}

TEST_F(RobotDiagnosisTest, TheSameLogGivesTheSameNumbers) {
  reality::Robot truth = drawn_->robot;
  truth.links[1].coulomb *= 1.5;
  const Diagnosis first = diagnosed(truth).diagnosis, second = diagnosed(truth).diagnosis;
  ASSERT_FALSE(first.causes.empty());
  EXPECT_EQ(first.causes.front().gain_heldout.value, second.causes.front().gain_heldout.value);
  EXPECT_EQ(first.causes.front().parameters.front().value, second.causes.front().parameters.front().value);
}

TEST(RobotDiagnosisOptionsTest, AnUnknownCauseIsRefused) {
  RobotDiagnosisOptions options;
  options.effects = {"muscle-wrap"};
  EXPECT_THROW(options.validate(), ConfigError);
}

}  // namespace
}  // namespace simgap
