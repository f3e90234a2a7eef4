// Derivatives of motions: those that are made anew along what motions tell, and those from longer steps of the bodies.
#include "simgap/fit/motions/motion_search.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

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
  MotionPosterior posterior = this->posterior(false);
  MotionSearchState state = beginSearch(posterior);
  const MotionFit fit = searchMotions(posterior, state, config_.rounds, {}, [](const MotionSearchState&) {});
  EXPECT_LT(fit.covariance.diagonal().maxCoeff(), 0.1);
}

TEST_F(MotionDerivatives, WhereTheSearchStandsBeforeItsEndLessIsKnown) {
  const MotionPosterior posterior = this->posterior(false);
  const MotionSearchState begin = beginSearch(posterior);
  const MotionLinearisation here = linearise(posterior, begin.z, begin.steps, {});
  const Eigen::MatrixXd covariance = covarianceAt(posterior, here);
  const Eigen::VectorXd left = stepLeftAt(posterior, here), none = Eigen::VectorXd::Zero(left.size());
  const Eigen::VectorXd sd = deviationsOf(posterior, here.at, here.jacobians, covariance, left);
  const Eigen::VectorXd at_the_end = deviationsOf(posterior, here.at, here.jacobians, covariance, none);
  ASSERT_GT(left.norm(), 0.0);
  for (Eigen::Index i = 0; i < sd.size(); ++i) {
    const double most = posterior.hasPrior(i) ? 1.0 : kInfinity;
    EXPECT_GE(sd[i], std::min(most, std::abs(left[i]))) << i;
    EXPECT_GE(sd[i], at_the_end[i]) << i;
    EXPECT_GE(at_the_end[i], std::min(most, std::sqrt(covariance(i, i)))) << i;
    EXPECT_LE(sd[i], most) << i;
  }
}

TEST_F(MotionDerivatives, AreAskedOfParametersThatHaveAStep) {
  const MotionPosterior posterior = this->posterior(false);
  const MotionSearchState begin = beginSearch(posterior);
  const MotionLinearisation all = linearise(posterior, begin.z, begin.steps, {});
  Eigen::VectorXd one = Eigen::VectorXd::Zero(posterior.size());
  one[1] = begin.steps[1];
  MotionEvaluation at = all.at;
  const std::vector<RowMajorF> asked = posterior.jacobian(begin.z, one, at);
  for (std::size_t m = 0; m < asked.size(); ++m) {
    EXPECT_EQ(asked[m].col(1), all.jacobians[m].col(1));
    EXPECT_TRUE(asked[m].col(0).isZero(0.0F));
  }
}

TEST_F(MotionDerivatives, WhatLiesBehindTheHorizonWeighsNothing) {
  MotionPosterior posterior = this->posterior(false);
  const MotionEvaluation at = posterior.evaluate(beginSearch(posterior).z);
  posterior.setHorizon(0.25);
  for (std::size_t m = 0; m < posterior.motions().size(); ++m) {
    const MotionResiduals& motion = posterior.motions()[m];
    const Eigen::VectorXd weights = posterior.weights(m, at.residuals[m]);
    const double begin = motion.timeAt(0.0), end = motion.timeAt(1.0);
    for (const ResidualBlock& block : motion.blocks()) {
      EXPECT_EQ(weights[block.first] > 0.0, block.time <= begin + 0.25 * (end - begin)) << block.time;
    }
  }
  const double part = posterior.objectiveOf(at, beginSearch(posterior).z);
  posterior.setHorizon(1.0);
  EXPECT_LT(part, posterior.objectiveOf(at, beginSearch(posterior).z));
}

TEST_F(MotionDerivatives, MotionsArePlayedAsFarAsTheyCount) {
  MotionPosterior posterior = this->posterior(false);
  const Eigen::VectorXd z = beginSearch(posterior).z;
  const MotionEvaluation whole = posterior.evaluate(z);
  posterior.setHorizon(0.25);
  const MotionEvaluation part = posterior.evaluate(z);
  for (std::size_t m = 0; m < posterior.motions().size(); ++m) {
    const MotionResiduals& motion = posterior.motions()[m];
    const double end = motion.timeAt(0.25);
    for (const ResidualBlock& block : motion.blocks()) {
      const auto is = part.residuals[m].segment(block.first, block.size);
      if (block.time <= end) {
        EXPECT_EQ(is, whole.residuals[m].segment(block.first, block.size)) << block.time;
      } else if (block.time > end + MotionResiduals::kWindow) {
        EXPECT_TRUE(is.isZero(0.0)) << block.time;
      }
    }
  }
}

/// Nine of ten windows lie within 1.6 times the loss's width, however far off the arm is.
TEST_F(MotionDerivatives, TheLossIsAsWideAsMostResidualsAre) {
  MotionPosterior posterior = this->posterior(false);
  const Eigen::VectorXd z = beginSearch(posterior).z;
  MotionEvaluation at = posterior.evaluate(z);
  const double narrow = at.objective;
  fitRobustScale(posterior, z, at);
  const double scale = posterior.robustScale();
  EXPECT_GT(scale, kRobustScale);  // the model is not the arm
  EXPECT_GT(at.objective, narrow);
  for (Eigen::VectorXd& residuals : at.residuals) residuals *= 2.0;
  fitRobustScale(posterior, z, at);
  EXPECT_NEAR(posterior.robustScale(), 2.0 * scale, 1e-9 * scale);
  for (Eigen::VectorXd& residuals : at.residuals) residuals *= 1e-3;
  fitRobustScale(posterior, z, at);
  EXPECT_EQ(posterior.robustScale(), kRobustScale);
}

/// Where fewer rounds may follow than there are beginnings, all of every motion is compared.
TEST_F(MotionDerivatives, TheFirstRoundsCompareTheBeginnings) {
  MotionPosterior posterior = this->posterior(false);
  for (const int rounds : {2, 5}) {
    MotionSearchState state = beginSearch(posterior);
    searchMotions(posterior, state, rounds, {}, [](const MotionSearchState&) {});
    std::vector<double> horizons;
    for (const MotionRound& round : state.history) horizons.push_back(round.horizon);
    const std::vector<double> expected = rounds == 2 ? std::vector{1.0, 1.0} : std::vector{0.125, 0.25, 0.5, 1.0, 1.0};
    ASSERT_EQ(std::ssize(horizons), rounds);
    EXPECT_TRUE(std::ranges::equal(horizons, std::span(expected).first(horizons.size())));
  }
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
