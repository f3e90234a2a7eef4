// The posterior of recorded motions: what its numbers mean, and that its derivatives are those of its residuals.
#include "simgap/fit/motions/motion_posterior.h"

#include <gtest/gtest.h>

#include "simgap/model/arm/arm_yaml.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

class MotionPosteriorTest : public testing::Test {
 protected:
  MotionPosteriorTest() : model_(readArm(YamlNode::parse(reality::toYaml(movingForearm().arm), "arm.yaml"))) {
    reality::MotionRigOptions options;
    options.duration = 1.5;
    putMotions(folder_, "set.yaml", 0, 2, options);
    const std::filesystem::path file = folder_.path() / "set.yaml";
    set_ = readMotionsFor(model_, YamlNode::load(file), file, [](const auto& table) { return CsvTable::load(table); });
  }
  MotionPosterior posterior(const std::string& config = forearmConfig()) const {
    const YamlNode node = YamlNode::parse(config, "config.yaml");
    return MotionPosterior(model_, set_.motions, {}, ParameterSpace::readChoices(node.at("parameters")), {}, {});
  }

  TemporaryFolder folder_;
  ArmModel model_;
  MotionSet set_;
};

TEST_F(MotionPosteriorTest, AWindowCountsByItsNoiseAndWhatLastsLonger) {
  const MotionPosterior all = posterior();
  const MotionResiduals& motion = all.motions()[0];
  const MotionDiscrepancy discrepancy;
  Eigen::Index numbers = 0;
  for (const ResidualBlock& block : motion.blocks()) {
    EXPECT_EQ(block.first, numbers);
    numbers += block.size;
    if (block.group != ChannelGroup::kShaft || block.begin > 0) continue;
    EXPECT_EQ(block.end, 5u);  // 50 ms at 100 Hz
    const double expected =
        all.noise().shafts * all.noise().shafts / 5.0 + discrepancy.shafts * discrepancy.shafts * 0.3 / 0.05;
    EXPECT_NEAR(block.sd * block.sd, expected, 1e-12);
  }
  EXPECT_EQ(numbers, motion.size());
}

TEST_F(MotionPosteriorTest, TheObjectiveIsThatOfItsResidualsAndPriors) {
  const MotionPosterior all = posterior();
  Eigen::VectorXd z = Eigen::VectorXd::Constant(all.size(), 0.3);
  const MotionEvaluation at = all.evaluate(z);
  ASSERT_TRUE(at.valid);
  double sum = z.squaredNorm();
  for (std::size_t m = 0; m < 2; ++m) {
    for (const ResidualBlock& block : all.motions()[m].blocks()) {
      sum += robustLoss(at.residuals[m].segment(block.first, block.size).squaredNorm());
    }
  }
  EXPECT_NEAR(at.objective, 0.5 * sum, 1e-9 * sum);
  EXPECT_DOUBLE_EQ(all.objectives({&z, 1}).front(), at.objective);
}

TEST_F(MotionPosteriorTest, TheGradientIsTheSlopeOfTheObjective) {
  const MotionPosterior all = posterior();
  const Eigen::VectorXd z = Eigen::VectorXd::Zero(all.size());
  MotionEvaluation at = all.evaluate(z);
  const Eigen::VectorXd steps = Eigen::VectorXd::Constant(all.size(), 0.02);
  const std::vector<RowMajorF> jacobians = all.jacobian(z, steps, at);
  const Eigen::VectorXd gradient = all.normalEquations(z, at, jacobians).gradient;
  for (const Eigen::Index i : {0, 1, 4, 5}) {  // lines and joint friction: smooth ones
    Eigen::VectorXd up = z, down = z;
    up[i] += 0.02;
    down[i] -= 0.02;
    const double slope = (all.evaluate(up).objective - all.evaluate(down).objective) / 0.04;
    EXPECT_NEAR(gradient[i], slope, 0.05 * gradient.norm()) << i;
  }
}

TEST_F(MotionPosteriorTest, WhatIsOneTogetherChangesInProportion) {
  model_.muscles[1].motor.coulomb_friction *= 3.0;
  const MotionPosterior all = posterior();
  Eigen::VectorXd z = Eigen::VectorXd::Zero(all.size());
  const auto& parameters = all.space().parameters();
  const auto at = std::ranges::find(parameters, "muscles.*.motor.coulomb_friction_Nm", &SearchParameter::name);
  ASSERT_NE(at, parameters.end());
  z[at - parameters.begin()] = 1.0;
  const ArmModel moved = all.modelAt(z);
  const double factor = moved.muscles[0].motor.coulomb_friction / model_.muscles[0].motor.coulomb_friction;
  EXPECT_NEAR(factor, std::exp(0.3), 1e-9);
  EXPECT_NEAR(moved.muscles[1].motor.coulomb_friction / model_.muscles[1].motor.coulomb_friction, factor, 1e-9);
}

}  // namespace
}  // namespace simgap::test
