// Cables that hang at a joint pull at it: what goes with the angle and is no weight.
#include <gtest/gtest.h>

#include "reality/servo_draws.h"
#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap::test {
namespace {

Diagnosis diagnoseHarness(std::uint64_t seed, bool slack) {
  reality::ServoDraw draw = reality::drawServoNone(seed, reality::Mechanism::kGearedJoint);
  draw.rig.rows = 8000;
  draw.secret.harness = 0.8;
  draw.secret.harness_slack = slack;
  PreparedLog log =
      prepareLog(CsvTable::parse(reality::recordServo(draw.rig, draw.secret).csv(), "log.csv"),
                 readBench(YamlNode::parse(reality::benchYaml(draw.rig), "rig.yaml")), ActuatorKind::kFriction);
  return diagnoseLog(subjectOf("stribeck"), log, {}).diagnosis;
}

TEST(JointSpring, IsNamedWhereAHarnessBecomesTaut) {
  const Diagnosis found = diagnoseHarness(20001, true);
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "joint-spring") << found.sentence;
  EXPECT_EQ(found.causes[0].ambiguous_with, std::vector<std::string>{}) << found.sentence;
}

TEST(JointSpring, IsNamedWhereAHosePullsBothWays) {
  const Diagnosis found = diagnoseHarness(20002, false);
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "joint-spring") << found.sentence;
}

}  // namespace
}  // namespace simgap::test
