// Recorded motions: what a set may hold, and the sentence for what it may not.
#include "simgap/measure/motion_set.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/core/random.h"
#include "simgap/measure/motion_noise.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const PoseLayout kMotionLayout{{"biceps", "triceps"}, {}, {{"elbow", JointType::kRevolute}}};
constexpr const char* kSet = "format: simgap/motions/1\nmotions:\n  - {name: a, muscles: m.csv, joints: j.csv}\n";
constexpr const char* kMuscles =
    "time_s,setpoint_biceps_deg,setpoint_triceps_rad,current_biceps_A\n0,90,1,0.1\n0.5,90,1,0.2\n1,180,1,0.3\n";
constexpr const char* kJoints = "time_s,elbow_deg\n0.1,30\n0.6,30\n1.1,40\n";

class MotionSetTest : public testing::Test {
 protected:
  MotionSet read(const std::string& set = kSet, const std::string& muscles = kMuscles,
                 const std::string& joints = kJoints) const {
    return readMotionSet(YamlNode::parse(set, "d/set.yaml"), "d/set.yaml", kMotionLayout, [&](const auto& file) {
      return CsvTable::parse(file == "d/m.csv" ? muscles : joints, file.string());
    });
  }
  std::string refusal(const std::string& set, const std::string& muscles = kMuscles,
                      const std::string& joints = kJoints) const {
    return errorOf([&] { read(set, muscles, joints); });
  }
};

TEST_F(MotionSetTest, HoldsCommandsAndMeasurementsInSi) {
  const RecordedMotion motion = read().motions.at(0);
  EXPECT_EQ(motion.name, "a");
  EXPECT_FALSE(motion.commands.linear);
  EXPECT_FALSE(motion.start);
  EXPECT_THAT(motion.times(), testing::ElementsAre(0.0, 0.5, 1.0));
  EXPECT_EQ(motion.commands.kinds[0], CommandKind::kSetpoint);
  EXPECT_NEAR(motion.commands.values(0, 2), 180.0 * kDegree, 1e-12);
  EXPECT_EQ(motion.muscles[0].currents[1], 0.2);
  EXPECT_TRUE(motion.muscles[0].shafts.empty());
  EXPECT_NEAR(motion.joints[2][0].angle, 40.0 * kDegree, 1e-12);
  EXPECT_EQ(firstChange(motion), 1.0);
}

TEST_F(MotionSetTest, HoldStartAndWeightAreTheMotions) {
  const RecordedMotion motion =
      read(replaced(kSet, "joints: j.csv",
                    "joints: j.csv, hold: linear, weight: 2, start: {joints: {elbow_deg: 30}, "
                    "shafts: {biceps_rad: 1.5, triceps_deg: 90}}"))
          .motions.at(0);
  EXPECT_TRUE(motion.commands.linear);
  EXPECT_EQ(motion.weight, 2.0);
  ASSERT_TRUE(motion.start);
  EXPECT_NEAR(motion.start->joints[0].angle, 30.0 * kDegree, 1e-12);
  EXPECT_NEAR(motion.start->shafts[1], 90.0 * kDegree, 1e-12);
  EXPECT_EQ(firstChange(motion), 0.5);  // a straight command begins to change behind the row before
}

TEST_F(MotionSetTest, SaysWhatIsWrongWithTheSet) {
  EXPECT_THAT(refusal(replaced(kSet, "motions/1", "motions/2")), StartsWith("2: d/set.yaml:1"));
  EXPECT_THAT(refusal(replaced(kSet, "name: a", "name: a, holds: step")), HasSubstr("holds"));
  EXPECT_THAT(refusal(replaced(kSet, "name: a", "name: a, start: moving")), HasSubstr("rest"));
  EXPECT_THAT(refusal("format: simgap/motions/1\nmotions: []\n"), HasSubstr("found no motion"));
  EXPECT_THAT(refusal(std::string(kSet) + "  - {name: a, muscles: m.csv, joints: j.csv}\n"), HasSubstr("stands twice"));
}

TEST(MotionCommands, ActAtTheTickOfTheirRowWhereverClocksBegin) {
  // Rows of 10 ms, ticks of 2 ms, which meet but for round-off; latencies of some ticks, as a rollout subtracts them.
  constexpr int kRows = 800, kTicksPerRow = 5;
  constexpr double kTick = 0.002;
  for (const double origin : {0.0, 1.7, 12.3, 1e4 + 0.1}) {
    MotionCommands commands;
    for (int row = 0; row < kRows; ++row) commands.times.push_back(origin + 0.01 * row);
    commands.values = Eigen::MatrixXd::Zero(1, kRows);
    commands.values.row(0).setLinSpaced(kRows, 0.0, kRows - 1.0);
    for (const int late : {0, 3, 7, 11}) {
      std::size_t row = 0;
      double command = 0.0;
      for (int tick = late; tick < kRows * kTicksPerRow; ++tick) {
        commands.at(origin + tick * kTick - late * kTick, row, {&command, 1});
        ASSERT_EQ(command, (tick - late) / kTicksPerRow) << origin << " s, " << late << " late, tick " << tick;
      }
    }
  }
}

TEST_F(MotionSetTest, TimesRise) {
  EXPECT_THAT(refusal(kSet, replaced(kMuscles, "\n1,180", "\n0.4,180")),
              StartsWith("3: d/m.csv:4: time goes back: found 0.4 s behind 0.5 s"));
  EXPECT_THAT(refusal(kSet, kMuscles, replaced(kJoints, "\n0.6,", "\n0.1,")),
              StartsWith("3: d/j.csv:3: time stands still"));
}

TEST_F(MotionSetTest, ClocksOverlap) {
  EXPECT_THAT(refusal(kSet, kMuscles, "time_s,elbow_deg\n100.1,30\n100.6,30\n"),
              AllOf(StartsWith("3: d/j.csv: found times from 100.1 to 100.6 s"), HasSubstr("do not overlap")));
}

TEST_F(MotionSetTest, TwoRowsOfCommandsAreNoMotion) {
  EXPECT_THAT(refusal(kSet, firstLines(replaced(kMuscles, "0.5,90", "0.01,90"), 3)),
              HasSubstr("expected at least 0.3 s of them between 0 and 0.01 s"));
}

TEST_F(MotionSetTest, ShaftsThatFollowInAnotherUnitAreNamed) {
  const auto shafts = [](double scale) {
    return fmt::format(
        "time_s,setpoint_biceps_rad,setpoint_triceps_rad,shaft_triceps_rad\n0,1,1,{}\n0.5,1,1,{}\n1,2,2,{}\n",
        1.01 * scale, 0.99 * scale, 1.95 * scale);
  };
  EXPECT_EQ(refusal(kSet, shafts(1.0)), "no error");
  EXPECT_THAT(refusal(kSet, shafts(kDegree)),
              HasSubstr("setpoint_triceps_rad: found shafts of 0.0172 times the "
                        "set-points, expected about 1: the set-points look like degrees"));
  EXPECT_THAT(refusal(kSet, shafts(1.0 / kDegree)), HasSubstr("the shafts look like degrees"));
}

TEST_F(MotionSetTest, EveryMuscleOfTheModelHasOneCommandAndNoOtherIsThere) {
  EXPECT_THAT(refusal(kSet, replaced(kMuscles, "setpoint_triceps_rad", "note")),
              StartsWith("3: d/m.csv:1: muscle triceps: found no command, expected one of setpoint_triceps_rad"));
  EXPECT_THAT(refusal(kSet, replaced(kMuscles, "setpoint_triceps_rad", "setpoint_tricep_rad")),
              HasSubstr("the model has no muscle 'tricep' (did you mean 'triceps'?)"));
  EXPECT_THAT(refusal(kSet, replaced(kMuscles, "current_biceps_A", "voltage_biceps_V")),
              HasSubstr("muscle biceps: found both setpoint_biceps and voltage_biceps"));
}

TEST_F(MotionSetTest, JointsOfAnotherKindBelongToAnotherModel) {
  EXPECT_THAT(refusal(kSet, kMuscles, "time_s,elbow_qw,elbow_qx,elbow_qy,elbow_qz\n0,1,0,0,0\n1,1,0,0,0\n"),
              HasSubstr("the position of a spherical joint"));
}

std::string frames(double speed_deg_s) {
  std::string text = "time_s,elbow_deg\n";
  for (int i = 0; i < 30; ++i) {
    text += fmt::format("{},{}\n", i / 60.0, 30.0 + speed_deg_s * i / 60.0 + (i % 2 ? 0.2 : -0.2));
  }
  return text;
}

TEST_F(MotionSetTest, AMotionThatIsSaidToRestDoesNotStartMoving) {
  EXPECT_EQ(read(kSet, kMuscles, frames(0.0)).motions.size(), 1u);
  EXPECT_THAT(refusal(kSet, kMuscles, frames(40.0)),
              AllOf(HasSubstr("motion a starts moving: found elbow at 40 deg/s"), HasSubstr("start:")));
}

TEST(MotionNoiseTest, IsThatOfTheSensorsWhateverMoves) {
  const PoseLayout layout{{"m"}, {}, {{"elbow", JointType::kRevolute}}};
  RecordedMotion motion;
  motion.muscles.resize(1);
  const CounterRandom random(1);
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto noise = random.normalPair({i, 0, 0, 0}), more = random.normalPair({i, 1, 0, 0});
    motion.joint_times.push_back(i / 60.0);
    motion.joints.push_back({{Eigen::Quaterniond::Identity(), std::sin(i / 30.0) + 0.005 * noise[0]}});
    motion.muscles[0].shafts.push_back(2.0 * std::sin(i / 50.0) + (i > 700 ? 1.0 : 0.0) + 0.01 * noise[1]);
    motion.muscles[0].currents.push_back((i % 500 < 250 ? 2.0 : -2.0) + 0.03 * more[0]);
  }
  const MotionNoise found = estimateNoise({&motion, 1}, layout);
  EXPECT_NEAR(found.joints[0], 0.005, 0.0005);
  EXPECT_NEAR(found.shafts, 0.01, 0.001);
  EXPECT_NEAR(found.currents, 0.03, 0.003);
}

}  // namespace
}  // namespace simgap::test
