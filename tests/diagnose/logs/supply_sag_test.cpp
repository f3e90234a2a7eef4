// A hobby servo logs the duty it sets as a voltage. What its supply loses to a resistance goes with the winding's
// current and not with the speed: the square of the whole voltage left half of it, which passed for friction by the
// load.
#include <gtest/gtest.h>

#include "reality/servo_draws.h"
#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap::test {
namespace {

TEST(SlowSupplySag, IsNoFrictionByTheLoad) {
  reality::ServoDraw draw = reality::drawServoNone(5203, reality::Mechanism::kVoltageServo);
  draw.rig.rows = 10000;
  draw.secret.rail_sag = 0.06;
  PreparedLog log =
      prepareLog(CsvTable::parse(reality::recordServo(draw.rig, draw.secret).csv(), "log.csv"),
                 readBench(YamlNode::parse(reality::benchYaml(draw.rig), "rig.yaml")), ActuatorKind::kFriction);
  const Diagnosis found = diagnoseLog(subjectOf("stribeck"), log, {}).diagnosis;
  ASSERT_EQ(found.causes.size(), 1u) << found.sentence;
  EXPECT_EQ(found.causes[0].effect, "torque-saturation") << found.sentence;
  EXPECT_TRUE(found.causes[0].ambiguous_with.empty()) << found.sentence;
}

}  // namespace
}  // namespace simgap::test
