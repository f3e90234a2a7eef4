// Combinations of parameters, from Jacobians made by hand.
#include "fit/poses/identifiability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/rig.h"

namespace simgap {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CombinationsOfAnArm : public testing::Test {
 protected:
  CombinationsOfAnArm() : rig_(test::recordRig(3)), space_(test::paperParameters(rig_.model)) {}

  Eigen::Index size() const { return static_cast<Eigen::Index>(space_.size()); }
  Eigen::Index indexOf(const std::string& name) const {
    for (std::size_t i = 0; i < space_.size(); ++i) {
      if (space_.parameters()[i].name == name) return static_cast<Eigen::Index>(i);
    }
    ADD_FAILURE() << name;
    return 0;
  }
  /// What a unit of each parameter's own value does when a unit of its z does what `jacobian` says.
  Eigen::MatrixXd perZ(Eigen::MatrixXd jacobian) const {
    const ScaledParameters scaled(space_);
    for (Eigen::Index i = 0; i < size(); ++i) jacobian.col(i) *= scaled.slope(i, 0.0);
    return jacobian;
  }

  test::RecordedRig rig_;
  ParameterSpace space_;
  Eigen::VectorXd unknowable_;
};

TEST_F(CombinationsOfAnArm, NoneWhereEachHasAnEffectOfItsOwn) {
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(size(), size());
  EXPECT_TRUE(findCombinations(jacobian, jacobian, space_, unknowable_).empty());
  EXPECT_LT(unknowable_.maxCoeff(), 1e-12);
}

TEST_F(CombinationsOfAnArm, NamesTwoOfOneMuscleOfWhichOnlyTheSumActs) {
  const Eigen::Index line = indexOf("muscles.muscle2.kite_line_length_m");
  const Eigen::Index radius = indexOf("muscles.muscle2.spindle_radius_m");
  Eigen::MatrixXd per_value = Eigen::MatrixXd::Identity(size(), size());
  per_value.row(radius).setZero();
  per_value(line, radius) = 1.0;  // a metre of either does the same, in this example
  const Eigen::MatrixXd jacobian = perZ(per_value);
  const auto found = findCombinations(jacobian, jacobian, space_, unknowable_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].always);
  EXPECT_THAT(found[0].text,
              AllOf(HasSubstr("kite_line_length_m and spindle_radius_m of muscle2"), HasSubstr("only their sum")));
  EXPECT_NEAR(unknowable_[line] + unknowable_[radius], 1.0, 1e-6) << "one direction of prior variance is never seen";
}

TEST_F(CombinationsOfAnArm, WhatOnlyTheRecordedPosesDoNotShowIsSaidSo) {
  const Eigen::Index radius = indexOf("muscles.muscle3.spindle_radius_m");
  const Eigen::MatrixXd anywhere = Eigen::MatrixXd::Identity(size(), size());
  Eigen::MatrixXd recorded = anywhere;
  recorded(radius, radius) = 0.0;
  const auto found = findCombinations(recorded, anywhere, space_, unknowable_);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].always);
  EXPECT_EQ(found[0].parameters, std::vector<std::size_t>{static_cast<std::size_t>(radius)});
  EXPECT_EQ(found[0].text, "spindle_radius_m of muscle3: has no effect, with these poses");
}

}  // namespace
}  // namespace simgap
