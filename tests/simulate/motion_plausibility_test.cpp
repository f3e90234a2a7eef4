// Recorded motions, starts and set-points whose numbers mean something else than their column says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/simulate/motion_inputs.h"
#include "simgap/simulate/possible_commands.h"
#include "support/motions.h"
#include "support/statics.h"

namespace simgap::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The joint's limits are 2 rad either way.
class MotionPlausibility : public testing::Test {
 protected:
  /// What reading a motion says whose joint swings by 1.5 rad. \param factor  of its angles  \param lost  frames that
  /// lie far outside  \param start  of the motion in its set  \param current  of the first muscle's motor
  std::string said(double factor, int lost, const std::string& start = "rest", double setpoint = 1.0,
                   double current = 0.1) const {
    CsvWriter muscles({"time_s", "setpoint_" + model_.muscles[0].name + "_rad",
                       "setpoint_" + model_.muscles[1].name + "_rad", "current_" + model_.muscles[0].name + "_A"});
    CsvWriter joints({"time_s", model_.joints[0].name + "_rad"});
    for (int i = 0; i < 100; ++i) {
      const double time = 0.02 * i, angle = i < lost ? 50.0 : 1.5 * std::sin(0.05 * i);
      muscles.add(time).add(setpoint).add(1.0 + 0.01 * i).add(i % 5 == 0 ? current : 0.0).endRow();
      joints.add(time).add(factor * angle).endRow();
    }
    const std::string set =
        "format: simgap/motions/1\nmotions:\n  - {name: lift, muscles: m, joints: j, start: " + start + "}\n";
    return errorOf([&] {
      readMotionsFor(model_, YamlNode::parse(set, "set.yaml"), "set.yaml", [&](const auto& file) {
        return CsvTable::parse(file == "m" ? muscles.text() : joints.text(), file.string() + ".csv");
      });
    });
  }
  std::string startAt(double angle) const {
    std::string start = "{joints: {" + model_.joints[0].name + "_rad: " + std::to_string(angle) + "}, shafts: {";
    for (const Muscle& muscle : model_.muscles) start += muscle.name + "_rad: 1, ";
    return start + "}}";
  }
  ArmModel model_ = modelOf(movingForearm().arm, true);
};

TEST_F(MotionPlausibility, MotionsAsTheyAreArePassed) {
  EXPECT_EQ(said(1.0, 0), "no error");
  EXPECT_EQ(said(1.0, 5, startAt(1.9)), "no error");  // frames of a capture that lost its markers
}

TEST_F(MotionPlausibility, JointAnglesInDegreesAreNamed) {
  EXPECT_THAT(said(1.0 / kDegree, 0), AllOf(HasSubstr("3: j: motion lift, "), HasSubstr("looks like degrees")));
}

TEST_F(MotionPlausibility, StartsBeyondTheLimitsAreNamed) {
  EXPECT_THAT(said(1.0, 0, startAt(2.3)), AllOf(HasSubstr("3: set.yaml: start of motion lift: "),
                                                HasSubstr("found 2.3"), Not(HasSubstr("degrees"))));
}

TEST_F(MotionPlausibility, SetpointsInDegreesAreNamed) {
  EXPECT_THAT(said(1.0, 0, "rest", 300.0), AllOf(HasSubstr("300 rad winds"), HasSubstr("of line")));
}

TEST_F(MotionPlausibility, CurrentsInMilliamperesAreNamed) {
  const Motor& motor = model_.muscles[0].motor;
  const double stalled = motor.supply_voltage / motor.resistance;
  EXPECT_EQ(said(1.0, 0, "rest", 1.0, 2.0 * stalled), "no error");  // as where it is reversed at full speed
  EXPECT_THAT(said(1.0, 0, "rest", 1.0, -100.0 * stalled),
              AllOf(HasSubstr("3: m: current_" + model_.muscles[0].name + "_A: "), HasSubstr("milliamperes?")));
}

TEST_F(MotionPlausibility, AStartFileBeyondTheLimitsIsRefused) {
  CsvWriter csv({model_.joints[0].name + "_rad", "shaft_" + model_.muscles[0].name + "_rad",
                 "shaft_" + model_.muscles[1].name + "_rad"});
  csv.add(2.3).add(1.0).add(1.0).endRow();
  const CsvTable table = CsvTable::parse(csv.text(), "start.csv");
  EXPECT_THAT(errorOf([&] { readMotionStart(table, model_, ""); }),
              AllOf(HasSubstr("3: start.csv: row 1: "), HasSubstr("expected an angle in rad within")));
}

}  // namespace
}  // namespace simgap::test
