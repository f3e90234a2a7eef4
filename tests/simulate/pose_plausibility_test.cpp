// Numbers that mean something else than their column says, and numbers that only a bad model contradicts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "simgap/core/rotation.h"
#include "simgap/simulate/replay.h"
#include "support/files.h"
#include "support/rig.h"

namespace simgap {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class PosePlausibility : public testing::TestWithParam<std::uint64_t> {
 protected:
  PosePlausibility() : rig_(test::recordRig(GetParam())), poses_(rig_.calibration) {}

  /// What reading these poses says.
  std::string said() const {
    std::vector<std::string> header{"pose"};
    for (const Muscle& muscle : rig_.model.muscles) header.push_back("shaft_" + muscle.name + "_rad");
    for (const char* q : {"_qw", "_qx", "_qy", "_qz"}) header.push_back(rig_.model.joints[0].name + q);
    header.push_back(rig_.model.joints[1].name + "_rad");
    CsvWriter csv(header);
    for (const Pose& pose : poses_) {
      csv.add(pose.name);
      for (const double shaft : pose.shafts) csv.add(shaft);
      const Eigen::Quaterniond& q = pose.joints[0].rotation;
      for (const double part : {q.w(), q.x(), q.y(), q.z()}) csv.add(part);
      csv.add(pose.joints[1].angle).endRow();
    }
    return test::errorOf([&] { readPosesFor(rig_.model, CsvTable::parse(csv.text(), "poses.csv")); });
  }

  test::RecordedRig rig_;
  std::vector<Pose> poses_;
};

TEST_P(PosePlausibility, PosesAsTheyAreArePassed) { EXPECT_EQ(said(), "no error"); }

TEST_P(PosePlausibility, ShaftsInDegreesAreNamed) {
  for (Pose& pose : poses_) {
    for (double& shaft : pose.shafts) shaft = toDegrees(shaft);
  }
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("look like degrees"), HasSubstr("_deg")));
}

TEST_P(PosePlausibility, JointAnglesInDegreesAreNamed) {
  for (Pose& pose : poses_) pose.joints[1].angle = toDegrees(pose.joints[1].angle);
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("looks like degrees")));
}

TEST_P(PosePlausibility, RadiansInAColumnOfDegreesAreNamed) {
  for (Pose& pose : poses_) pose.joints[1].angle *= kDegree;
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("_deg: "), HasSubstr("look like radians")));
}

TEST_P(PosePlausibility, JointAnglesOfTheOtherSignAreNamed) {
  for (Pose& pose : poses_) pose.joints[1].angle *= -1.0;
  poses_.front().joints[1].angle = -2.0;  // of limits from 0 to 2.36
  EXPECT_THAT(said(),
              AllOf(HasSubstr("3: poses.csv: "), HasSubstr("its sign looks turned"), Not(HasSubstr("degrees"))));
}

TEST_P(PosePlausibility, JointAnglesOfTheOtherSignAreNamedWhereAQuarterTurnHoldsThem) {
  for (std::size_t p = 0; p < poses_.size(); ++p) poses_[p].joints[1].angle = -0.06 * static_cast<double>(p % 20);
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("its sign looks turned")));
  // A zero that is off leaves some where they may be.
  for (std::size_t p = 0; p < poses_.size(); ++p) poses_[p].joints[1].angle += 0.8;
  EXPECT_THAT(said(), Not(HasSubstr("its sign looks turned")));
}

TEST_P(PosePlausibility, QuaternionsInTheOrderOfRosAreNamed) {
  for (Pose& pose : poses_) {
    const Eigen::Quaterniond q = pose.joints[0].rotation;
    pose.joints[0].rotation = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
  }
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("look like x, y, z, w"), HasSubstr("ROS")));
}

TEST_P(PosePlausibility, InvertedQuaternionsAreNamedOrNothingIs) {
  // Six of the twelve models move their shoulder well enough to tell (correlations of 0.6 to 0.94).
  const std::set<std::uint64_t> told{1, 4, 6, 7, 8, 9};
  for (Pose& pose : poses_) pose.joints[0].rotation = pose.joints[0].rotation.conjugate();
  if (told.contains(GetParam())) {
    EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: "), HasSubstr("they look like the parent in the child")));
  } else {
    EXPECT_EQ(said(), "no error");
  }
}

TEST_P(PosePlausibility, AWrongModelIsNotTakenForAWrongFile) {
  // Shafts of the wrong muscles: the model contradicts every pose, and no other reading explains them.
  for (Pose& pose : poses_) std::rotate(pose.shafts.begin(), pose.shafts.begin() + 4, pose.shafts.end());
  EXPECT_EQ(said(), "no error");
}

TEST_P(PosePlausibility, AbsurdNumbersAreRefused) {
  poses_[2].shafts[0] = 4000.0;
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv: pose "), HasSubstr("found 4000")));
  poses_ = rig_.calibration;
  poses_[2].joints[1].angle = -1e9;
  EXPECT_THAT(said(), AllOf(HasSubstr("3: poses.csv:4: column "), HasSubstr("found -1e+09")));
}

INSTANTIATE_TEST_SUITE_P(Rigs, PosePlausibility, testing::Range(std::uint64_t{0}, std::uint64_t{12}));

}  // namespace
}  // namespace simgap
