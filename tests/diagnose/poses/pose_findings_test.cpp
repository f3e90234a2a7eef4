// What a cause has to show before it is a finding, and what is said of one that does not.
#include <gtest/gtest.h>

#include <utility>

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

}  // namespace
}  // namespace simgap
