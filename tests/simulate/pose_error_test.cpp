#include "simgap/simulate/pose_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/report/poses/pose_report.h"

namespace simgap {
namespace {

using ::testing::IsEmpty;

const PoseLayout kLayout{{"biceps"}, {}, {{"shoulder", JointType::kSpherical}, {"elbow", JointType::kRevolute}}};

JointPosition turnedJoint(double angle, const Eigen::Vector3d& axis) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), 0.0};
}
JointPosition bent(double angle) { return {Eigen::Quaterniond::Identity(), angle}; }

Pose pose(const JointPosition& shoulder, double elbow) { return {"p", {0.0}, {shoulder, bent(elbow)}, 1, {0.0, 0.0}}; }

PoseOutcome steadyPose(const JointPosition& shoulder, double elbow) {
  PoseOutcome outcome;
  outcome.status = PoseStatus::kSteady;
  outcome.joints = {shoulder, bent(elbow)};
  return outcome;
}
PoseOutcome invalid(PoseStatus status, int worst, double value) {
  PoseOutcome outcome;
  outcome.status = status;
  outcome.worst = worst;
  outcome.worst_value = value;
  return outcome;
}

TEST(PoseError, SumsSquaresAndAveragesAmountsByHand) {
  const JointPosition start = turnedJoint(0.4, {1, 2, 3});
  const JointPosition further = turnedJoint(0.7, {1, 2, 3});  // about the same axis: 0.3 rad away
  const std::vector<Pose> poses{pose(start, 1.0), pose(further, -0.5)};
  const std::vector<PoseOutcome> outcomes{steadyPose(further, 1.2), steadyPose(turnedJoint(0.6, {1, 2, 3}), -0.1)};
  const Assessment judged = assess(kLayout, poses, outcomes);
  EXPECT_NEAR(judged.errors[0][0], 0.3, 1e-15);
  EXPECT_NEAR(judged.errors[0][1], 0.2, 1e-15);
  EXPECT_NEAR(judged.errors[1][0], 0.1, 1e-15);
  EXPECT_NEAR(judged.errors[1][1], 0.4, 1e-15);
  EXPECT_NEAR(judged.mje[0], 0.2, 1e-15);
  EXPECT_NEAR(judged.mje[1], 0.3, 1e-15);
  EXPECT_NEAR(judged.fitness, 0.09 + 0.04 + 0.01 + 0.16, 1e-15);
  EXPECT_EQ(judged.valid, 2u);
}

TEST(PoseError, ThePapersObjectiveCountsABallAQuarterAndAHingeInFull) {
  const std::vector<Pose> poses{pose(turnedJoint(0.0, {1, 0, 0}), 1.0)};
  const std::vector<PoseOutcome> outcomes{steadyPose(turnedJoint(0.3, {1, 0, 0}), 1.2)};
  EXPECT_NEAR(assess(kLayout, poses, outcomes).fitness, 0.09 + 0.04, 1e-15);
  const Assessment printed = assess(kLayout, poses, outcomes, PoseObjective::kPaper);
  // arccos(Q . Q') of 001 eq. 3 and 4, by hand: Q . Q' = cos(0.15).
  EXPECT_NEAR(printed.fitness, std::pow(std::acos(std::cos(0.15)), 2) + 0.04, 1e-12);
  EXPECT_NEAR(printed.mje[0], 0.3, 1e-15) << "errors are reported in full";
}

TEST(PoseError, ErrorsOfOppositeSignDoNotCancel) {
  const JointPosition same = turnedJoint(0.0, {1, 0, 0});
  const std::vector<Pose> poses{pose(same, 0.0), pose(same, 0.0)};
  const Assessment judged = assess(kLayout, poses, std::vector{steadyPose(same, 0.5), steadyPose(same, -0.5)});
  EXPECT_EQ(judged.mje[1], 0.5);
  EXPECT_EQ(judged.fitness, 0.5);
}

TEST(PoseError, IsBlindToTheSignOfAQuaternion) {
  const JointPosition measured = turnedJoint(3.0, {0, 1, 0});
  JointPosition opposite = turnedJoint(2.9, {0, 1, 0});
  opposite.rotation.coeffs() *= -1.0;
  const Assessment judged = assess(kLayout, std::vector{pose(measured, 0)}, std::vector{steadyPose(opposite, 0)});
  EXPECT_NEAR(judged.errors[0][0], 0.1, 1e-14);
  // arccos(Q . Q') as printed would be far from half of that.
  EXPECT_GT(std::acos(measured.rotation.dot(opposite.rotation)), 3.0);
}

TEST(PoseError, AnInvalidPoseHasNoErrorAndLeavesNoFitness) {
  const JointPosition same = turnedJoint(0.0, {1, 0, 0});
  const std::vector<Pose> poses{pose(same, 0.0), pose(same, 0.0), pose(same, 0.0)};
  const std::vector<PoseOutcome> outcomes{invalid(PoseStatus::kNotFinite, -1, -1.0), steadyPose(same, 0.25),
                                          PoseOutcome{}};
  const Assessment judged = assess(kLayout, poses, outcomes);
  EXPECT_EQ(judged.valid, 1u);
  EXPECT_THAT(judged.errors[0], IsEmpty());
  EXPECT_THAT(judged.errors[2], IsEmpty());
  EXPECT_EQ(judged.mje[1], 0.25);  // of the valid pose
  EXPECT_TRUE(std::isnan(judged.fitness));
}

TEST(PoseError, WithoutAValidPoseNothingIsKnown) {
  const JointPosition same = turnedJoint(0.0, {1, 0, 0});
  const Assessment judged = assess(kLayout, std::vector{pose(same, 0)}, std::vector<PoseOutcome>(1));
  EXPECT_EQ(judged.valid, 0u);
  EXPECT_TRUE(std::isnan(judged.mje[0]) && std::isnan(judged.mje[1]) && std::isnan(judged.fitness));
}

TEST(PoseError, SaysWhyAPoseIsInvalid) {
  EXPECT_EQ(describe(invalid(PoseStatus::kAcquisitionError, 0, 12.34 * kDegree), kLayout),
            "acquisition error of biceps, 12.3 deg");
  EXPECT_EQ(describe(invalid(PoseStatus::kNotSteady, 1, 0.5), kLayout), "elbow not steady, 0.5 rad/s");
  PoseOutcome creeping = invalid(PoseStatus::kNotSteady, 1, 0.01);
  creeping.settle_needed = 48.3;
  EXPECT_EQ(describe(creeping, kLayout), "elbow not steady, 0.01 rad/s, would rest within some 48 s of settling");
  EXPECT_EQ(describe(invalid(PoseStatus::kNotFinite, -1, -1), kLayout), "not finite");
  EXPECT_EQ(describe(PoseOutcome{}, kLayout), "skipped");
}

TEST(PoseError, OnlyThePapersColumnHoldsHalfAngles) {
  ValidationResult result;
  result.layout = kLayout;
  result.set = {"p.csv", {pose(turnedJoint(0.0, {1, 0, 0}), 0.0)}};
  result.assessment =
      assess(kLayout, result.set.poses, std::vector{steadyPose(turnedJoint(20 * kDegree, {0, 0, 1}), 10 * kDegree)});
  const Json json = toJson(result);
  EXPECT_NEAR(json.at("mje_deg").at("shoulder").get<double>(), 20.0, 1e-12);
  EXPECT_NEAR(json.at("mje_deg").at("elbow").get<double>(), 10.0, 1e-12);
  EXPECT_NEAR(json.at("paper_mje_deg").at("shoulder").get<double>(), 10.0, 1e-12);
  EXPECT_NEAR(json.at("paper_mje_deg").at("elbow").get<double>(), 10.0, 1e-12);
  EXPECT_NEAR(json.at("poses")[0].at("error_deg").at("shoulder").get<double>(), 20.0, 1e-12);
}

}  // namespace
}  // namespace simgap
