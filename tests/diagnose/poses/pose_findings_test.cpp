// What a cause has to show before it is a finding, and what is said of one that does not.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "diagnose/poses/pose_conclusion.h"
#include "support/drawn_poses.h"

namespace simgap {
namespace {

/// Of a diagnosis that tests these effects.
Diagnosis diagnoseFor(const reality::PoseDraw& draw, const PoseSet& set, std::vector<std::string> effects) {
  PoseDiagnosisOptions options;
  options.effects = std::move(effects);
  options.ignore_faults = true;
  return diagnosePoses(test::modelOf(draw), set, test::paperConfig().parameters, test::paperConfig().noise, options,
                       [](const std::string&, double) {})
      .diagnosis;
}

// The cables of two potentiometers were exchanged. A wrap takes a part of that where it was chosen, and nothing where
// it was not.
TEST(PoseFindings, WhatPosesHeldOutDenyIsACandidate) {
  const reality::PoseDraw draw = reality::drawPoses(21, {.poses = 48, .causes = 0});
  PoseSet set = test::posesOf(draw, draw.poses);
  for (Pose& pose : set.poses) std::swap(pose.shafts[0], pose.shafts[1]);
  const Diagnosis found =
      diagnoseFor(draw, set, {"spindle-coiling", "cord-hardening", "passive-joint-torque", "muscle-wrap"});
  EXPECT_EQ(found.verdict, DiagnosisVerdict::kNothingFound) << found.sentence;
  ASSERT_EQ(found.candidates.size(), 1u) << found.sentence;
  EXPECT_EQ(found.candidates[0].effect, "muscle-wrap");
  EXPECT_LE(found.candidates[0].gain_heldout.value, 0.0);
  EXPECT_NE(found.candidates[0].reason.find("held out"), std::string::npos) << found.candidates[0].reason;
  EXPECT_EQ(found.extended.mse_heldout, found.baseline.mse_heldout);
}

// The elbow's angle counts the other way, from another zero: whatever takes a part of that is no answer.
TEST(PoseFindings, CausesThatLeaveMostOfTheErrorAreNone) {
  const reality::PoseDraw draw = reality::drawPoses(21, {.poses = 48, .causes = 0});
  PoseSet set = test::posesOf(draw, draw.poses);
  for (Pose& pose : set.poses) pose.joints[1].angle = 2.0 - pose.joints[1].angle;
  const Diagnosis found = diagnoseFor(draw, set, {"cord-hardening", "passive-joint-torque", "spindle-coiling"});
  EXPECT_EQ(found.verdict, DiagnosisVerdict::kUnexplained) << found.sentence;
  EXPECT_TRUE(found.causes.empty());
  ASSERT_FALSE(found.candidates.empty());
  EXPECT_NE(found.candidates[0].reason.find("times the noise is left"), std::string::npos);
  // What was likely beside it without a sure gain is a candidate, too.
  const auto unsure = [](const Candidate& c) { return c.reason.starts_with("no sure gain on poses"); };
  EXPECT_TRUE(std::ranges::any_of(found.candidates, unsure));
}

TEST(PoseFindings, ASentenceCountsTheRivalsOfTheCauseThatHasThem) {
  PoseSelection selection;
  Diagnosis d;
  d.causes.resize(2);
  d.causes[0].effect = "cord-creep";
  d.causes[1].effect = "payload";
  d.causes[1].target = "forearm";
  d.causes[1].ambiguous_with = {"gravity-tilt", "joint-stiction:elbow", "muscle-wrap:biceps"};
  concludePoses(selection, 20, false, d);
  EXPECT_EQ(d.verdict, DiagnosisVerdict::kUnexplained);
  EXPECT_EQ(d.sentence, "something like payload:forearm is there, but these poses do not tell it from 3 other causes");
}

TEST(PoseFindings, WhereNothingIsFoundWhatIsLeftIsUnsureParametersOrSaidToBeMore) {
  PoseSelection selection;
  Diagnosis d;
  d.baseline.mse_heldout = d.extended.mse_heldout = 4.0;
  d.noise_floor = 1.0;
  selection.excess_sd = 0.1;
  concludePoses(selection, 20, false, d);
  EXPECT_TRUE(d.sentence.ends_with("; left is 2.0 times the noise, no more than unsure parameters explain"))
      << d.sentence;
  selection.excess = 0.3;
  concludePoses(selection, 20, false, d);
  EXPECT_TRUE(d.sentence.ends_with("; their squared error is 30 % above what noise and parameters explain"))
      << d.sentence;
}

TEST(PoseFindings, TheFirstLineSaysWhatIsLeft) {
  PoseSelection selection;
  Diagnosis d;
  selection.causes.push_back({{findArmEffect("payload"), "forearm", {}}, 9.0, 0.0, {}, {}, {}});
  d.causes.resize(1);
  d.causes[0].effect = "payload";
  d.baseline.mse_heldout = 4.0;
  d.extended.mse_heldout = 1.0;
  d.noise_floor = 0.9;
  concludePoses(selection, 20, false, d);
  EXPECT_NE(d.sentence.find("takes away 75 % of the squared error on 20 poses that were held out. Left: 25 %, about "
                            "the noise"),
            std::string::npos)
      << d.sentence;
  d.noise_floor = 0.16;
  concludePoses(selection, 20, false, d);
  EXPECT_NE(d.sentence.find("Left: 25 %, 2.5 times the noise"), std::string::npos) << d.sentence;
  EXPECT_FALSE(leavesTooMuch(selection, d, d.noise_floor)) << "cross-validation sees no structure";
  selection.excess = 5.0;
  selection.excess_sd = 0.1;
  EXPECT_TRUE(leavesTooMuch(selection, d, d.noise_floor));
  d.noise_floor = 0.9;
  EXPECT_FALSE(leavesTooMuch(selection, d, d.noise_floor));
}

// An angle sensor that was bent got a joint's centre for a name that took away 0.1 % of the error, 1.5 times the noise.
TEST(PoseFindings, CausesThatHardlyTakeAnythingAwayAreNone) {
  PoseSelection selection;
  selection.excess = 0.4;  // with others, which are none either
  selection.excess_plain = 1.0;
  selection.excess_sd = 0.1;
  Diagnosis d;
  d.baseline.mse_heldout = 2.25;
  d.noise_floor = 1.0;
  d.extended.mse_heldout = 2.248;
  EXPECT_TRUE(leavesTooMuch(selection, d, d.noise_floor));
  d.extended.mse_heldout = 2.0;
  EXPECT_FALSE(leavesTooMuch(selection, d, d.noise_floor)) << "a fifth of what is beyond the noise";
  d.baseline.mse_heldout = 1.02;
  d.extended.mse_heldout = 1.01;
  EXPECT_FALSE(leavesTooMuch(selection, d, d.noise_floor)) << "nothing is left to be taken away";
}

}  // namespace
}  // namespace simgap
