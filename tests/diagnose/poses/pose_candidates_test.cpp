// Which models a diagnosis of poses leaves to be asked about a change.
#include "diagnose/poses/pose_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/poses/pose_rig.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;

ArmCause causeOf(const std::string& effect, const std::string& target, const EffectParameters& start) {
  return {findArmEffect(effect), target, start};
}

TEST(PoseCandidates, NoneHoldsACauseTwice) {
  // The second cause was named after it had been noted as a rival of the first, and as one that was refused.
  PoseRig rig(1, {.poses = 12, .effect = "payload"});
  const ArmCause payload = causeOf("payload", "link2", {0.05, 0.15});
  const ArmCause tilt = causeOf("gravity-tilt", "", {0.0, 0.0});
  const ArmCause passive = causeOf("passive-joint-torque", "joint2", {0.05, 0.3, 0.0});
  PoseFit fit(rig.problem, rig.set.poses, {payload, tilt});
  fit.posterior().whitenLike(rig.plain.posterior());
  fit.descend(fit.extended(rig.plain.z()));
  PoseSelection selection;
  selection.causes.resize(2);
  selection.causes[0].cause = payload;
  selection.causes[0].rivals = {tilt.label(), passive.label()};
  selection.causes[0].instead = {tilt, passive};
  selection.causes[1].cause = tilt;
  selection.causes[1].instead = {payload};
  selection.refused = {payload, passive};
  dropNamedRivals(selection);
  EXPECT_THAT(selection.causes[0].rivals, ElementsAre(passive.label()));
  const std::vector<CandidateModel> candidates = candidateModels(rig.problem, rig.plain, 1.0, fit, selection);
  std::vector<std::string> names;
  for (const CandidateModel& candidate : candidates) names.push_back(candidate.causes);
  EXPECT_THAT(names,
              ElementsAre("payload:link2, gravity-tilt", "gravity-tilt, passive-joint-torque:joint2", "payload:link2",
                          "gravity-tilt", "payload:link2, gravity-tilt, passive-joint-torque:joint2", "none"));
  EXPECT_EQ(candidates[0].log_odds, 0.0);
}

}  // namespace
}  // namespace simgap::test
