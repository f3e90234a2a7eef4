#include "simgap/simulate/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/analytic_evaluator.h"
#include "support/arms.h"
#include "support/files.h"

namespace simgap {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Replay, JudgesEveryPoseAndSaysHowFarItIs) {
  const ArmModel arm = test::analyticArm();
  PoseSet set{"poses.csv", {}};
  while (set.poses.size() < 130) {
    for (const Pose& pose : test::analyticPoses()) set.poses.push_back(pose);
  }
  test::AnalyticEvaluator evaluator([](const ArmModel&, std::size_t pose, PoseOutcome& outcome) {
    if (pose == 1) outcome.status = PoseStatus::kNotSteady, outcome.worst = 1;
  });
  std::vector<std::size_t> done;
  const Assessment judged = replayAll(evaluator, arm, set, [&](std::size_t count) { done.push_back(count); });
  EXPECT_THAT(done, ElementsAre(64u, 128u, 130u));
  ASSERT_EQ(judged.outcomes.size(), 130u);
  EXPECT_EQ(judged.valid, 127u) << "pose 1 of each of three calls is invalid";
  EXPECT_THAT(judged.errors[1], IsEmpty());
  EXPECT_EQ(judged.errors[0].size(), arm.joints.size());
  EXPECT_THAT(describeInvalid(judged, set, arm.poseLayout(), "equilibrium"),
              testing::StartsWith("3 of 130 poses are invalid: "));
}

TEST(Replay, NamesTheCordsThatWereStretchedTooFar) {
  const PoseLayout layout = test::analyticArm().poseLayout();
  PoseOutcome once, invalid;
  once.cord_expansion = {0.1, 2.0 * ShockCord::kLinearRange};
  const std::vector<PoseOutcome> outcomes{once, invalid};
  const std::vector<std::string> sentences = stretchedCords(outcomes, layout);
  ASSERT_EQ(sentences.size(), 1u);
  EXPECT_THAT(sentences[0], testing::StartsWith("triceps: its cord is stretched by "));
}

TEST(Replay, APendulumOnItsHeadIsNoOtherStableEquilibrium) {
  const ArmModel arm = test::pendulum();
  PoseSet set{"poses.csv", {Pose{}}};
  set.poses[0].name = "down";
  PoseOutcome down;
  down.status = PoseStatus::kSteady;
  down.joints = {test::hingeAt(0.0)};
  const std::vector<PoseOutcome> outcomes{down};
  EXPECT_EQ(otherEquilibria(arm, set, outcomes), "");
}

}  // namespace
}  // namespace simgap
