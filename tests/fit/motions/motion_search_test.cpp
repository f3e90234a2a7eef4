// Derivatives of motions: those that are made anew along what motions tell, and those from longer steps of the bodies.
#include "simgap/fit/motions/motion_search.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/yaml.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "support/motions.h"
#include "support/statics.h"

namespace simgap {
namespace {

class MotionDerivatives : public testing::Test {
 protected:
  MotionDerivatives() {
    const auto commands = [](std::uint64_t draw) { return test::forearmSetpoints(static_cast<int>(draw)); };
    set_ = test::recordMotions(test::trueForearm(), model_, commands, 0, 3, {});
  }
  MotionPosterior posterior(bool coarse) const {
    MotionPosterior::Options options = config_.motions;
    options.coarse_changes = coarse;
    return {model_, set_.motions, {}, config_.parameters, PoseNoise{}, options};
  }
  static double missed(const MotionLinearisation& a, const MotionLinearisation& b, const Eigen::VectorXd& way) {
    double difference = 0.0, size = 0.0;
    for (std::size_t m = 0; m < a.jacobians.size(); ++m) {
      const Eigen::VectorXf one = a.jacobians[m] * way.cast<float>(), other = b.jacobians[m] * way.cast<float>();
      difference += static_cast<double>((one - other).squaredNorm());
      size += static_cast<double>(other.squaredNorm());
    }
    return std::sqrt(difference / size);
  }

  ArmModel model_ = test::modelOf(test::movingForearm().arm, true);
  MotionCalibrationConfig config_ =
      MotionCalibrationConfig::read(YamlNode::parse(test::forearmConfig(), "forearm_config.yaml"));
  MotionSet set_;
};

TEST_F(MotionDerivatives, MadeAnewTheyAreThoseOfThePlaceWhereMotionsTellMost) {
  const MotionPosterior posterior = this->posterior(false);
  const MotionSearchState begin = beginSearch(posterior);
  MotionLinearisation here = linearise(posterior, begin.z, begin.steps, {});
  const Eigen::VectorXd z = Eigen::VectorXd::Constant(begin.z.size(), 0.8);
  const MotionLinearisation there = linearise(posterior, z, 0.2 * begin.steps, {});
  here.z = there.z;
  here.at = there.at;
  const SymmetricEigen told = symmetricEigen(posterior.normalEquations(there.z, there.at, there.jacobians).curvature);
  const Eigen::VectorXd most = told.vectors.rightCols(1);
  const double old = missed(here, there, most);
  const long rollouts = renew(posterior, here, {});
  EXPECT_GT(rollouts, 0);
  EXPECT_LE(rollouts, posterior.size() * std::ssize(posterior.motions()));
  EXPECT_GT(old, 0.02);
  EXPECT_LT(missed(here, there, most), 0.25 * old);
}

/// But for what stick and slip leave in them at any step: differences over half the way differ by as much.
TEST_F(MotionDerivatives, FromLongerStepsOfTheBodiesTheyAreTheSame) {
  const MotionPosterior fine = posterior(false), coarse = posterior(true);
  const MotionSearchState begin = beginSearch(fine);
  const MotionLinearisation one = linearise(coarse, begin.z, begin.steps, {}),
                            other = linearise(fine, begin.z, begin.steps, {}),
                            shorter = linearise(fine, begin.z, 0.5 * begin.steps, {});
  for (Eigen::Index i = 0; i < fine.size(); ++i) {
    const Eigen::VectorXd way = Eigen::VectorXd::Unit(fine.size(), i);
    EXPECT_LT(missed(one, other, way), std::max(0.05, 1.5 * missed(shorter, other, way))) << i;
  }
}

TEST_F(MotionDerivatives, LongerStepsOfTheBodiesMoveTheArmAlike) {
  const MotionOptions usual, longer = usual.coarser();
  EXPECT_EQ(longer.rollout.step, 2.0 * usual.rollout.step);
  const auto fine = playAll(model_, set_.motions, usual), coarse = playAll(model_, set_.motions, longer);
  for (std::size_t m = 0; m < fine.size(); ++m) {
    ASSERT_TRUE(coarse[m].valid);
    double squares = 0.0;
    for (std::size_t f = 0; f < fine[m].joints.size(); ++f) {
      squares += std::pow(fine[m].joints[f].angle - coarse[m].joints[f].angle, 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(fine[m].joints.size())), 0.1 * kDegree);
    EXPECT_LT((fine[m].shafts - coarse[m].shafts).norm() / std::sqrt(static_cast<double>(fine[m].shafts.size())),
              0.1 * kDegree);
  }
}

/// The forearm falls to its stop: its response bends by more than a tenth from one side of a place to the other, which
/// is no noise. Three movements tell all of its parameters.
TEST_F(MotionDerivatives, WhatABentResponseTellsIsKept) {
  const MotionPosterior posterior = this->posterior(false);
  MotionSearchState state = beginSearch(posterior);
  const MotionFit fit = searchMotions(posterior, state, config_.rounds, {}, [](const MotionSearchState&) {});
  EXPECT_LT(fit.covariance.diagonal().maxCoeff(), 0.1);
}

/// Scores are products of derivatives and residuals: were noise left in them, intervals would be widened by what no
/// motion tells.
TEST_F(MotionDerivatives, HoldNoMoreThanIsToldThroughTheirNoise) {
  const MotionPosterior posterior = this->posterior(false);
  const MotionSearchState begin = beginSearch(posterior);
  const MotionFit fit = fitAt(posterior, begin.z, begin.steps, {});
  const MotionEvaluation at = posterior.evaluate(fit.z);
  const Eigen::VectorXd held = posterior.normalEquations(fit.z, at, fit.jacobians).curvature.diagonal();
  const Eigen::VectorXd told = fit.covariance.inverse().diagonal();
  for (Eigen::Index i = 0; i < told.size(); ++i) EXPECT_LE(held[i], told[i] * (1.0 + 1e-6)) << i;
}

}  // namespace
}  // namespace simgap
