// What is said of motions that a fit has not seen: how their errors scatter.
#include "fit/motions/motion_prediction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/yaml.h"
#include "support/motions.h"
#include "support/statics.h"

namespace simgap {
namespace {

class MotionPredictionTest : public testing::Test {
 protected:
  MotionPredictionTest() {
    const auto commands = [](std::uint64_t draw) { return test::forearmSetpoints(static_cast<int>(draw)); };
    set_ = test::recordMotions(test::trueForearm(), model_, commands, 0, 3, {});
    posterior_.emplace(model_, set_.motions, std::span<const Pose>(), config_.parameters, PoseNoise{}, config_.motions);
  }
  /// For three more motions, where the parameters are known and three fitted left these mean squares of the joint.
  double predictedWidth(const std::vector<double>& squares) const {
    MotionFit fit;
    fit.z = Eigen::VectorXd::Zero(posterior_->size());
    fit.covariance = 1e-12 * Eigen::MatrixXd::Identity(fit.z.size(), fit.z.size());
    std::vector<MotionRms> fitted;
    for (const double square : squares) fitted.push_back({{std::sqrt(square)}, 0.005, 0.03});
    const auto predicted = predictMotions(*posterior_, fit, 1.0, fitted, *posterior_);
    return (predicted->upper.joints[0] - predicted->lower.joints[0]) / predicted->median.joints[0];
  }

  ArmModel model_ = test::modelOf(test::movingForearm().arm, true);
  MotionCalibrationConfig config_ =
      MotionCalibrationConfig::read(YamlNode::parse(test::forearmConfig(), "forearm_config.yaml"));
  MotionSet set_;
  std::optional<MotionPosterior> posterior_;
};

/// The mean of three mean squares of n numbers of white noise, and of three more: 4/(3 n) is the variance of the ratio.
TEST_F(MotionPredictionTest, MotionsThatLookAlikeAreToldNoBetterThanTheirNoise) {
  double frames = 0.0;
  for (const ResidualBlock& block : posterior_->motions()[0].blocks()) {
    if (block.group == ChannelGroup::kJoint) frames += static_cast<double>(block.end - block.begin);
  }
  const double of_noise = 1.645 * std::sqrt(4.0 / (3.0 * frames));
  const double alike = predictedWidth({9e-6, 9e-6, 9e-6});
  EXPECT_GT(alike, of_noise);
  EXPECT_LT(alike, 2.0 * of_noise);
}

/// A new mean of three is a Student's t of two degrees of freedom about theirs: mean +- 2.92 sd sqrt(1/3 + 1/3).
TEST_F(MotionPredictionTest, MotionsThatDifferAreToldAsTheyScatter) {
  const double sd = 0.3;  // of the squares' logarithms
  const double width = predictedWidth({9e-6 * std::exp(-sd), 9e-6, 9e-6 * std::exp(sd)});
  const double of_student = 2.92 * sd * std::sqrt(2.0 / 3.0);
  EXPECT_GT(width, 0.8 * of_student);
  EXPECT_LT(width, 1.6 * of_student);
}

}  // namespace
}  // namespace simgap
