// What every kind of joint promises, run over all of them.
#include "simgap/core/joint_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "support/files.h"

namespace simgap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kRounding = 1e-15;

/// A position with something in every member, of which a kind uses its own.
JointPosition position(double angle) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0)), angle};
}

class EveryJointKind : public ::testing::TestWithParam<const JointKind*> {};

TEST_P(EveryJointKind, ReadsWhatItWrites) {
  const JointKind& kind = *GetParam();
  std::vector<std::string> columns = positionColumns(kind.type, "elbow");
  ASSERT_EQ(columns.size(), kind.columns.size());
  CsvWriter csv(columns);
  for (const double angle : {0.3, -1.1}) {
    const std::vector<double> cells = kind.cells(position(angle));
    ASSERT_EQ(cells.size(), columns.size());
    for (const double cell : cells) csv.add(cell);
    csv.endRow();
  }
  const std::vector<JointPosition> read = kind.read(CsvTable::parse(csv.text(), "poses.csv"), "elbow");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_NEAR(jointError(kind.type, read[0], position(0.3)), 0.0, kRounding);
  EXPECT_NEAR(jointError(kind.type, read[1], position(-1.1)), 0.0, kRounding);
}

TEST_P(EveryJointKind, DifferencesAreAsLongAsTheErrorIsLarge) {
  const JointKind& kind = *GetParam();
  EXPECT_NEAR(kind.difference(position(0.2), position(0.5)).norm(), 0.3, kRounding);
  EXPECT_NEAR(kind.difference(position(0.5), position(0.2)).norm(), jointError(kind.type, position(0.5), position(0.2)),
              kRounding);
  EXPECT_NEAR(std::abs(kind.angle(position(-0.7))), 0.7, kRounding);
  EXPECT_EQ(kind.angle(position(0.0)), 0.0);
}

TEST_P(EveryJointKind, TheMeanLiesInTheMiddle) {
  const JointKind& kind = *GetParam();
  const std::vector<JointPosition> repeats = {position(0.1), position(0.5)};
  EXPECT_NEAR(jointError(kind.type, kind.mean(repeats), position(0.3)), 0.0, 10 * kRounding);
}

TEST_P(EveryJointKind, IsFoundByItsNameAndType) {
  const JointKind& kind = *GetParam();
  EXPECT_EQ(&kindOf(kind.type), &kind);
  EXPECT_EQ(readJointType(YamlNode::parse("type: " + std::string(kind.name), "arm.yaml").at("type")), kind.type);
}

INSTANTIATE_TEST_SUITE_P(All, EveryJointKind, ::testing::ValuesIn(joint_kinds::all().begin(), joint_kinds::all().end()),
                         [](const auto& kind) { return std::string(kind.param->name); });

TEST(JointKind, RefusesWhatIsNoPosition) {
  const auto sentence = [](const std::string& text) {
    return test::errorOf([&] { kindOf(JointType::kSpherical).read(CsvTable::parse(text, "poses.csv"), "shoulder"); });
  };
  const std::string header = "shoulder_qw,shoulder_qx,shoulder_qy,shoulder_qz\n1,0,0,0\n";
  EXPECT_THAT(sentence(header + "1,0.1,0,0\n"),
              HasSubstr("poses.csv:3: quaternion of joint shoulder: found length 1.00499, expected 1"));
  EXPECT_THAT(positionColumns(JointType::kRevolute, "elbow"), ElementsAre("elbow_rad"));
}

}  // namespace
}  // namespace simgap
