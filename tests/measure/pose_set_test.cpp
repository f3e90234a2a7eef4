#include "simgap/measure/pose_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/files.h"

namespace simgap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const PoseLayout kLayout{
    {"biceps", "triceps"}, {}, {{"shoulder", JointType::kSpherical}, {"elbow", JointType::kRevolute}}};
const std::string kHeader =
    "pose,repeat,shaft_biceps_rad,shaft_triceps_rad,shoulder_qw,shoulder_qx,shoulder_qy,shoulder_qz,elbow_rad\n";

PoseSet read(const std::string& text) { return readPoseSet(CsvTable::parse(text, "p.csv"), kLayout); }
std::string errorOf(const std::string& text) {
  return test::errorOf([&] { read(text); });
}

TEST(PoseSet, ReadsOnePoseAsItStands) {
  const PoseSet set = read(kHeader + "up,0,1.5,-2.25,0.6,0,0.8,0,0.3\n");
  EXPECT_EQ(set.file, "p.csv");
  ASSERT_EQ(set.poses.size(), 1u);
  const Pose& pose = set.poses[0];
  EXPECT_EQ(pose.name, "up");
  EXPECT_EQ(pose.repeats, 1);
  EXPECT_THAT(pose.shafts, ElementsAre(1.5, -2.25));
  EXPECT_NEAR(geodesicAngle(pose.joints[0].rotation, Eigen::Quaterniond(0.6, 0, 0.8, 0)), 0.0, 1e-14);
  EXPECT_EQ(pose.joints[1].angle, 0.3);
  EXPECT_THAT(pose.spread, ElementsAre(0.0, 0.0));
}

TEST(PoseSet, JointsThatStandStillWhereverTheShaftsAreWereNotMeasured) {
  const std::string stuck = "0.6,0,0.8,0,0.3\n";
  EXPECT_THAT(errorOf(kHeader + "a,0,1,2," + stuck + "b,0,3,4," + stuck + "c,0,5,6," + stuck),
              HasSubstr("the same joint positions in all 3 poses though the shafts stand elsewhere"));
  EXPECT_EQ(read(kHeader + "a,0,1,2," + stuck + "b,0,1,2," + stuck + "c,0,1,2," + stuck).poses.size(), 3u);
  EXPECT_EQ(read(kHeader + "a,0,1,2," + stuck + "b,0,3,4," + stuck + "c,0,5,6,0.6,0,0.8,0,0.31\n").poses.size(), 3u);
}

TEST(PoseSet, AveragesRepeatsAndSaysHowTheySpread) {
  // Turned about z by 0.1 and 0.3 rad: mean 0.2, deviations 0.1 each, spread sqrt(2 * 0.01 / 1).
  const auto about_z = [](double angle) {
    return std::to_string(std::cos(angle / 2)) + ",0,0," + std::to_string(std::sin(angle / 2));
  };
  const PoseSet set = read(kHeader + "a,0,1,10," + about_z(0.1) + ",0.2\nb,0,7,8,1,0,0,0,0\na,1,3,20," + about_z(0.3) +
                           ",0.6\na,2,5,60," + about_z(0.2) + ",0.7\n");
  ASSERT_EQ(set.poses.size(), 2u);
  const Pose& pose = set.poses[0];
  EXPECT_EQ(pose.name, "a");
  EXPECT_EQ(pose.repeats, 3);
  EXPECT_THAT(pose.shafts, ElementsAre(3.0, 30.0));
  EXPECT_NEAR(pose.joints[1].angle, 0.5, 1e-15);
  const Eigen::Quaterniond mean(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(geodesicAngle(pose.joints[0].rotation, mean), 0.0, 1e-5);  // the file has six digits
  EXPECT_NEAR(pose.spread[0], std::sqrt((0.01 + 0.01 + 0.0) / 2), 1e-5);
  EXPECT_NEAR(pose.spread[1], std::sqrt((0.09 + 0.01 + 0.04) / 2), 1e-15);
  EXPECT_EQ(set.poses[1].name, "b");
  EXPECT_EQ(set.poses[1].repeats, 1);
  EXPECT_EQ(set.poses[1].spread[1], 0.0);
}

TEST(PoseSet, TheSignOfAQuaternionDoesNotMatterInTheMean) {
  const std::string one = "a,0,0,0,0.8,0.6,0,0,0\n", other = "a,1,0,0,0.6,0.8,0,0,0\n";
  const std::string other_sign = "a,1,0,0,-0.6,-0.8,0,0,0\n";
  const PoseSet plain = read(kHeader + one + other);
  const PoseSet flipped = read(kHeader + one + other_sign);
  EXPECT_NEAR(geodesicAngle(plain.poses[0].joints[0].rotation, flipped.poses[0].joints[0].rotation), 0.0, 1e-14);
  EXPECT_NEAR(plain.poses[0].spread[0], flipped.poses[0].spread[0], 1e-14);
  // Half way between the two: deviations of half the angle between them.
  const double between = 2 * std::acos(0.96);
  EXPECT_NEAR(plain.poses[0].spread[0], between / std::sqrt(2.0), 1e-12);
}

TEST(PoseSet, NormalisesQuaternionsWithinAThousandthAndRefusesOthers) {
  const std::string good = "a,0,0,0,1,0,0,0,0\n";
  for (const char* length : {"1.0009", "0.9991", "-1.0009"}) {
    const PoseSet set = read(kHeader + "a,0,0,0,0," + length + ",0,0,0\n");
    EXPECT_NEAR(set.poses[0].joints[0].rotation.norm(), 1.0, 1e-15) << length;
  }
  EXPECT_EQ(errorOf(kHeader + good + "b,0,0,0,1.002,0,0,0,0\n"),
            "3: p.csv:3: quaternion of joint shoulder: found length 1.002, expected 1 within 0.001");
  EXPECT_THAT(errorOf(kHeader + good + "b,0,0,0,1,0,0,0,0\n" + "c,0,0,0,0,0,0.998,0,0\n"),
              HasSubstr("p.csv:4: quaternion of joint shoulder: found length 0.998"));
  EXPECT_THAT(errorOf(kHeader + "c,0,0,0,0,0,0,0,0\n"), HasSubstr("found length 0"));
}

TEST(PoseSet, RefusesAMuscleTheModelLacksAndOneTheFileLacks) {
  const std::string row = "a,0,0,0,1,0,0,0,0";
  const std::string header = kHeader.substr(0, kHeader.size() - 1);
  EXPECT_EQ(errorOf(header + ",shaft_wing_rad\n" + row + ",1\n"),
            "3: p.csv:1: column shaft_wing_rad: the model has no muscle 'wing'");
  const std::string lacking = errorOf(test::replaced(kHeader, "shaft_triceps_rad", "other") + row + "\n");
  EXPECT_THAT(lacking, HasSubstr("3: p.csv:1: found no column shaft_triceps_rad"));
  EXPECT_THAT(errorOf(test::replaced(kHeader, "elbow_rad", "elbow_m") + row + "\n"), HasSubstr("3: p.csv:1: "));
  EXPECT_THAT(errorOf(test::replaced(kHeader, "shoulder_qy", "shoulder_y") + row + "\n"),
              HasSubstr("found no column shoulder_qy"));
  EXPECT_THAT(errorOf(test::replaced(kHeader, "pose,", "name,") + row + "\n"), HasSubstr("found no column pose"));
}

TEST(PoseSet, RefusesTheSamePoseAndRepeatTwice) {
  const std::string row = ",0,0,1,0,0,0,0\n";
  EXPECT_EQ(errorOf(kHeader + "a,0" + row + "a,1" + row + "b,0" + row + "a,1" + row),
            "3: p.csv:5: pose a repeat 1 stands twice");
  const std::string without = test::replaced(kHeader, "repeat,", "");
  EXPECT_EQ(errorOf(without + "a" + row + "a" + row), "3: p.csv:3: pose a stands twice, and there is no column repeat");
  EXPECT_EQ(read(without + "a" + row + "b" + row).poses.size(), 2u);
}

TEST(PoseSet, RefusesCellsThatHoldNothingOrNoFiniteNumber) {
  EXPECT_EQ(errorOf(kHeader), "3: p.csv: found no rows, expected at least one pose");
  EXPECT_THAT(errorOf(""), HasSubstr("3: p.csv:1: found an empty file"));
  const std::string good = "a,0,1,2,1,0,0,0,0.1\n";
  for (const char* bad : {"nan", "inf", "-inf", "", "1e999", "two"}) {
    EXPECT_THAT(errorOf(kHeader + good + "b,0,1," + bad + ",1,0,0,0,0.1\n"),
                HasSubstr("3: p.csv:3: column shaft_triceps_rad: found "))
        << bad;
    EXPECT_THAT(errorOf(kHeader + "b,0,1,2,1,0,0,0," + bad + "\n" + good),
                HasSubstr("3: p.csv:2: column elbow_rad: found "))
        << bad;
    EXPECT_THAT(errorOf(kHeader + good + "b,0,1,2,1,0," + bad + ",0,0\n"),
                HasSubstr("3: p.csv:3: column shoulder_qy: found "))
        << bad;
  }
  EXPECT_EQ(errorOf(kHeader + good + ",0,1,2,1,0,0,0,0.1\n"), "3: p.csv:3: column pose: found an empty cell");
  EXPECT_EQ(errorOf(kHeader + good + "a,,1,2,1,0,0,0,0.1\n"), "3: p.csv:3: column repeat: found an empty cell");
  EXPECT_THAT(errorOf(kHeader + good + "b,0,1,2,1,0,0,0\n"), HasSubstr("3: p.csv:3: found 8 cells, expected 9"));
}

TEST(PoseSet, ConvertsUnitsAndKeepsOtherColumnsOut) {
  const std::string header =
      "time_s,shaft_biceps_deg,tension_biceps_N,shaft_biceps_rad_s,pose,shaft_triceps_rad,"
      "shoulder_qw,shoulder_qx,shoulder_qy,shoulder_qz,elbow_deg,weather\n";
  const PoseSet set = read(header + "0,180,12,3,p,-1,1,0,0,0,-90,fine\n");
  EXPECT_NEAR(set.poses[0].shafts[0], 180 * kDegree, 1e-15);
  EXPECT_EQ(set.poses[0].shafts[1], -1.0);
  EXPECT_NEAR(set.poses[0].joints[1].angle, -90 * kDegree, 1e-15);
  EXPECT_THAT(errorOf(test::replaced(header, "weather", "elbow_rad") + "0,180,12,3,p,-1,1,0,0,0,-90,1\n"),
              HasSubstr("3: p.csv:1: found both elbow_deg and elbow_rad"));
}

TEST(PoseSet, FollowsTheOrderOfTheModelNotOfTheFile) {
  const std::string row = "a,0,1,2,1,0,0,0,0\n";
  const std::string swapped = test::replaced(
      test::replaced(test::replaced(kHeader, "shaft_biceps_rad", "x"), "shaft_triceps_rad", "shaft_biceps_rad"), ",x,",
      ",shaft_triceps_rad,");
  EXPECT_THAT(read(kHeader + row).poses[0].shafts, ElementsAre(1.0, 2.0));
  EXPECT_THAT(read(swapped + row).poses[0].shafts, ElementsAre(2.0, 1.0));
}

TEST(PoseSet, UnpacksWhatBeginsAsGzip) {
  const std::string text = kHeader + "a,0,1,2,1,0,0,0,0.25\n";
  const std::string packed = test::gzipped(text);
  EXPECT_EQ(read(packed).poses[0].joints[1].angle, 0.25);
  // Packed files that stand one behind the other are one file.
  EXPECT_EQ(read(test::gzipped(kHeader) + test::gzipped("a,0,1,2,1,0,0,0,0.25\n")).poses.size(), 1u);
  EXPECT_THAT(errorOf(packed.substr(0, packed.size() - 9)), HasSubstr("3: p.csv:"));
  EXPECT_THAT(errorOf(packed.substr(0, packed.size() - 9)), HasSubstr("the gzip data break off here"));
  std::string damaged = packed;
  damaged[damaged.size() - 6] = static_cast<char>(~damaged[damaged.size() - 6]);
  EXPECT_THAT(errorOf(damaged), HasSubstr("the gzip data are damaged here"));
  EXPECT_THAT(test::errorOf([&] { CsvTable::parse(text, "p.csv.gz"); }), HasSubstr("found no gzip data"));
}

TEST(PoseSet, NamesAJointOfAnotherType) {
  const PoseLayout layout{{"a"}, {}, {{"wrist", JointType::kSpherical}}};
  const std::string hinge = "pose,shaft_a_rad,wrist_deg\np0,0,1\n";
  EXPECT_THAT(
      test::errorOf([&] { readPoseSet(CsvTable::parse(hinge, "p.csv"), layout); }),
      ::testing::HasSubstr("3: p.csv:1: joint wrist: found wrist_rad, the position of a revolute joint, expected "
                           "wrist_qw, wrist_qx, wrist_qy, wrist_qz: the model's type of it is spherical"));
  const PoseLayout other{{"a"}, {}, {{"wrist", JointType::kRevolute}}};
  const std::string ball = "pose,shaft_a_rad,wrist_qw,wrist_qx,wrist_qy,wrist_qz\np0,0,1,0,0,0\n";
  EXPECT_THAT(test::errorOf([&] { readPoseSet(CsvTable::parse(ball, "p.csv"), other); }),
              ::testing::HasSubstr("expected wrist_rad: the model's type of it is revolute"));
}

}  // namespace
}  // namespace simgap
