// Cables that hang at a joint pull at it, and cables that are bent rub: what goes with the angle and is no weight.
#include <gtest/gtest.h>

#include "reality/servo_draws.h"
#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap::test {
namespace {

/// Diagnosed as a drive with nothing hidden but what `hide` puts there.
template <typename Hide>
Diagnosis diagnoseServo(std::uint64_t seed, reality::Mechanism mechanism, const Hide& hide) {
  reality::ServoDraw draw = reality::drawServoNone(seed, mechanism);
  draw.rig.rows = 8000;
  hide(draw.secret);
  const std::string bench = reality::benchYaml(draw.rig);
  PreparedLog log =
      prepareLog(CsvTable::parse(reality::recordServo(draw.rig, draw.secret).csv(), "log.csv"),
                 bench.empty() ? Bench{} : readBench(YamlNode::parse(bench, "rig.yaml")), ActuatorKind::kFriction);
  return diagnoseLog(subjectOf(draw.law), log, {}).diagnosis;
}

void expectOnly(const Diagnosis& found, const std::string& cause) {
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, cause) << found.sentence;
  EXPECT_EQ(found.causes[0].ambiguous_with, std::vector<std::string>{}) << found.sentence;
}

TEST(JointSpring, IsNamedWhereAHarnessBecomesTaut) {
  expectOnly(diagnoseServo(20001, reality::Mechanism::kGearedJoint,
                           [](reality::ServoSecret& secret) { secret.harness = 0.8, secret.harness_slack = true; }),
             "joint-spring");
}

TEST(JointSpring, IsNamedWhereAHosePullsBothWays) {
  expectOnly(diagnoseServo(20002, reality::Mechanism::kGearedJoint,
                           [](reality::ServoSecret& secret) { secret.harness = 0.8, secret.harness_slack = false; }),
             "joint-spring");
}

TEST(BendFriction, IsNamedWhereTheCableIsBentBothWays) {
  expectOnly(diagnoseServo(20003, reality::Mechanism::kCable,
                           [](reality::ServoSecret& secret) { secret.bend = 0.7, secret.bend_both_ways = true; }),
             "bend-friction");
}

}  // namespace
}  // namespace simgap::test
