#include "diagnose/poses/pose_score.h"

#include <gtest/gtest.h>

#include "pose_rig.h"

namespace simgap::test {
namespace {

std::vector<ArmHypothesis> hypothesesOf(const PoseRig& rig, const std::vector<std::string>& effects) {
  std::vector<NotTestable> none;
  return poseHypotheses(rig.problem.nominal, rig.set.poses, effects, none);
}

TEST(PoseScore, OrdinaryParametersTakeAwayInformation) {
  PoseRig rig(21, {.poses = 20, .causes = 0});
  const PoseScore score(rig.plain);
  for (const ArmHypothesis& h : hypothesesOf(rig, {"payload"})) {
    const Eigen::VectorXd s = score.slopes(rig.problem, {h.effect, h.target, h.starts.front()}).col(0);
    EXPECT_GT(score.information(s), 0.0) << h.target;
    EXPECT_LT(score.information(s), s.squaredNorm()) << h.target;
    EXPECT_NEAR(score.information(2.0 * s), 4.0 * score.information(s), 1e-9 * s.squaredNorm());
  }
}

TEST(PoseScore, PlacesASlipWhereItHappened) {
  PoseRig rig(11, {.poses = 40, .effect = "potentiometer-slip"});
  const reality::HiddenCause& hidden = rig.draw.hidden[0];
  std::vector<ArmHypothesis> hypotheses = hypothesesOf(rig, {"potentiometer-slip", "payload"});
  const std::vector<ArmHypothesis> before = hypotheses;
  placeMoments(rig.problem, rig.plain, hypotheses);
  const double apart = rig.set.poses[1].time - rig.set.poses[0].time;
  for (std::size_t h = 0; h < hypotheses.size(); ++h) {
    if (!hypotheses[h].effect->from_moment) {
      EXPECT_EQ(hypotheses[h].starts, before[h].starts);
      continue;
    }
    if (hypotheses[h].target != hidden.target) continue;
    ASSERT_FALSE(hypotheses[h].starts.empty());
    EXPECT_NEAR(hypotheses[h].starts[0][1], hidden.moment, 3.0 * apart);
  }
}

TEST(PoseScore, OnePoseThatIsOffIsNoSlip) {
  PoseRig rig(21, {.poses = 40, .causes = 0});
  rig.set.poses.back().joints[1].angle += 0.1;
  PoseFit fit(rig.problem, rig.set.poses, {});
  fit.setSolution(rig.plain.z());
  std::vector<ArmHypothesis> hypotheses = hypothesesOf(rig, {"potentiometer-slip"});
  placeMoments(rig.problem, fit, hypotheses);
  const std::vector<Pose>& poses = rig.set.poses;
  for (const ArmHypothesis& h : hypotheses) {
    ASSERT_FALSE(h.starts.empty()) << h.target;
    for (const EffectParameters& start : h.starts) {
      EXPECT_GT(start[1], poses[3].time) << h.target;
      EXPECT_LT(start[1], poses[poses.size() - 4].time) << h.target;
    }
  }
}

TEST(PoseScore, EveryHypothesisHasASmallestMagnitude) {
  PoseRig rig(21, {.poses = 20, .causes = 0});
  const std::vector<ArmHypothesis> hypotheses = hypothesesOf(rig, {"gravity-tilt", "payload"});
  const std::vector<Detectable> least = detectableMagnitudes(rig.problem, rig.plain, hypotheses);
  ASSERT_EQ(least.size(), hypotheses.size());
  for (const Detectable& d : least) EXPECT_GT(d.magnitude95, 0.0) << d.effect;
}

}  // namespace
}  // namespace simgap::test
