// The negative log posterior: its derivatives, its weights, and what a flipped pose does to a fit.
#include "simgap/fit/poses/pose_posterior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>

#include "simgap/fit/poses/pose_uncertainty.h"
#include "simgap/fit/poses/posterior_search.h"
#include "support/rig.h"

namespace simgap {
namespace {

class PosteriorOfARig : public testing::Test {
 protected:
  PosteriorOfARig() : rig_(test::recordRig(3)), space_(test::paperParameters(rig_.model)) {}
  test::RecordedRig rig_;
  ParameterSpace space_;
};

// Somewhere off the hand measurements, so that log scales and rotations count.
Eigen::VectorXd somewhere(Eigen::Index n) {
  Eigen::VectorXd z(n);
  for (Eigen::Index i = 0; i < n; ++i) z[i] = 0.3 * std::sin(1.7 * static_cast<double>(i));
  return z;
}

TEST_F(PosteriorOfARig, JacobiansAgreeWithDifferences) {
  PosePosterior posterior(rig_.model, rig_.calibration, space_, {});
  const Eigen::VectorXd z = somewhere(posterior.parameters().size());
  const std::vector<PoseResidual> at = posterior.evaluate(z, true);
  const double h = 1e-5;
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(z.size(), i);
    const std::vector<PoseResidual> plus = posterior.evaluate(z + step, false);
    const std::vector<PoseResidual> minus = posterior.evaluate(z - step, false);
    for (std::size_t p = 0; p < at.size(); ++p) {
      ASSERT_TRUE(at[p].valid && plus[p].valid && minus[p].valid);
      const Eigen::VectorXd slope = (plus[p].error - minus[p].error) / (2.0 * h);
      EXPECT_LT((at[p].jacobian.col(i) - slope).norm(), 1e-5 * std::max(1.0, slope.norm()))
          << space_.parameters()[i].name << ", pose " << p;
    }
  }
}

TEST_F(PosteriorOfARig, TorqueJacobiansAgreeWithDifferences) {
  PosePosterior posterior(rig_.model, rig_.calibration, space_, {});
  const Eigen::VectorXd z = somewhere(posterior.parameters().size());
  const std::vector<PoseResidual> at = posterior.evaluateTorques(z, 2.0 * kDegree);
  const double h = 1e-5;
  for (Eigen::Index i = 0; i < z.size(); i += 7) {
    const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(z.size(), i);
    const std::vector<PoseResidual> plus = posterior.evaluateTorques(z + step, 2.0 * kDegree);
    const std::vector<PoseResidual> minus = posterior.evaluateTorques(z - step, 2.0 * kDegree);
    for (std::size_t p = 0; p < at.size(); ++p) {
      const Eigen::VectorXd slope = (plus[p].error - minus[p].error) / (2.0 * h);
      EXPECT_LT((at[p].jacobian.col(i) - slope).norm(), 1e-5 * std::max(1.0, slope.norm())) << "pose " << p;
    }
  }
}

TEST_F(PosteriorOfARig, ScaledParametersComeBack) {
  const ScaledParameters scaled(space_);
  const Eigen::VectorXd z = somewhere(scaled.size());
  EXPECT_LT((scaled.scaled(scaled.values(z)) - z).lpNorm<Eigen::Infinity>(), 1e-9);
  // The first parameter is an attachment with 7 mm; stiffness is on a log scale with 13 %.
  EXPECT_NEAR(scaled.value(0, 1.0) - scaled.value(0, 0.0), 7e-3, 1e-15);
  // 9 parameters of each muscle: two attachments, the line, the stiffness, the radius.
  EXPECT_EQ(space_.parameters()[8 * 9 + 7].name, "muscles.muscle9.shock_cord.stiffness_N_m");
  EXPECT_NEAR(scaled.value(8 * 9 + 7, 1.0), 950.0 * std::exp(0.13), 1e-9);
}

TEST_F(PosteriorOfARig, RepeatsCountBySpreadAndNumber) {
  // Without joint friction S_p is the capture's alone: 0.3 deg once, 0.3 / sqrt(5) deg for five repeats that agree with
  // it, and more when they do not.
  const PoseNoise noise{0.3 * kDegree, false};
  std::vector<Pose> poses(rig_.calibration.begin(), rig_.calibration.begin() + 3);
  poses[1].repeats = poses[2].repeats = 5;
  poses[1].spread = {0.3 * kDegree * std::sqrt(3.0), 0.3 * kDegree};
  poses[2].spread = {3.0 * kDegree * std::sqrt(3.0), 3.0 * kDegree};
  const PosePosterior posterior(rig_.model, poses, space_, noise);
  const auto sd = [&](std::size_t pose) { return 1.0 / posterior.whitening(pose)(3, 3); };
  EXPECT_NEAR(sd(0), 0.3 * kDegree, 1e-12);
  EXPECT_NEAR(sd(1), 0.3 * kDegree / std::sqrt(5.0), 1e-12);
  EXPECT_NEAR(sd(2), std::sqrt((0.3 * 0.3 + 3.0 * 3.0) / 2.0 / 5.0) * kDegree, 1e-12);  // 4 and 4 degrees of freedom
}

TEST_F(PosteriorOfARig, FrictionWidensSoftDirections) {
  const PosePosterior stiff(rig_.model, rig_.calibration, space_, {0.3 * kDegree, false});
  const PosePosterior held(rig_.model, rig_.calibration, space_, {0.3 * kDegree, true});
  for (std::size_t p = 0; p < rig_.calibration.size(); ++p) {
    EXPECT_LT(held.whitening(p).determinant(), 0.9 * stiff.whitening(p).determinant());
  }
}

PosteriorFit best(PosePosterior& posterior) {
  const auto fits = searchPosterior(posterior, {4, 0, 1});
  const auto found = std::min_element(fits.begin(), fits.end(),
                                      [](const auto& a, const auto& b) { return a.objective < b.objective; });
  posterior.whiten(found->z);
  return *found;
}

TEST(PosePosterior, FlippedPosesDoNotRuinTheFitAndAreListed) {
  reality::RigOptions options;
  options.calibration = 30;
  const test::RecordedRig clean = test::recordRig(5, options);
  options.flipped = 2;
  const test::RecordedRig flipped = test::recordRig(5, options);
  const ParameterSpace space = test::paperParameters(clean.model);
  PosePosterior from_clean(clean.model, clean.calibration, space, {});
  PosePosterior from_flipped(flipped.model, flipped.calibration, space, {});
  const Eigen::VectorXd z = best(from_flipped).z;
  const auto without = test::meanJointErrors(from_clean.modelAt(best(from_clean).z), clean.validation);
  const auto with = test::meanJointErrors(from_flipped.modelAt(z), flipped.validation);
  EXPECT_LT(with[0], 1.25 * without[0]);
  EXPECT_LT(with[1], 1.25 * without[1] + 0.1);
  const PoseUncertainty uncertainty = assessUncertainty(from_flipped, z, space);
  for (std::size_t p = 0; p < flipped.calibration.size(); ++p) {
    EXPECT_EQ(uncertainty.distances[p] > kRobustScale, p < 2) << "pose " << p << ": " << uncertainty.distances[p];
  }
}

/// The poses of a rig visited again and again, each time with 0.05 rad of noise on every shaft.
std::vector<Pose> visitedAgain(const test::RecordedRig& rig, std::size_t count) {
  std::vector<Pose> poses;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (std::size_t p = 0; p < count; ++p) {
    poses.push_back(rig.calibration[p % rig.calibration.size()]);
    for (double& shaft : poses.back().shafts) shaft += noise(random);
  }
  return poses;
}

TEST(PosteriorSearch, ManyPosesWithNoisyShaftsDoNotStopIt) {
  // One of so many is always far from where it was measured, and the search for its equilibrium has to go a long way.
  const test::RecordedRig rig = test::recordRig(1);
  const std::vector<Pose> poses = visitedAgain(rig, 500);
  PosePosterior posterior(rig.model, poses, test::paperParameters(rig.model), {});
  for (const PosteriorFit& fit : searchPosterior(posterior, {3, 0, 1})) EXPECT_TRUE(std::isfinite(fit.objective));
}

TEST(PosteriorSearch, StartsThatShareADescentLoseNothing) {
  const test::RecordedRig rig = test::recordRig(1);
  const std::vector<Pose> poses = visitedAgain(rig, 300);
  PosePosterior posterior(rig.model, poses, test::paperParameters(rig.model), {});
  const auto fits = searchPosterior(posterior, {6, 0, 1});
  ASSERT_EQ(fits.size(), 6u);
  std::set<double> found;
  for (const PosteriorFit& fit : fits) found.insert(fit.objective);
  EXPECT_LT(found.size(), fits.size()) << "none shares: this shows nothing";
  // Other starts, each with a descent of its own on all poses: none ends lower by what a likelihood would notice.
  constexpr double kUnnoticed = 0.1;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int start = 0; start < 3; ++start) {
    Eigen::VectorXd z(posterior.parameters().size());
    for (double& value : z) value = normal(random);
    PosePosterior own = posterior;
    z = balanceTorques(own, z);
    own.whitenLike(posterior);
    EXPECT_GT(descendPosterior(own, z).objective, *found.begin() - kUnnoticed);
  }
}

TEST(PosteriorSearch, PosesInTheOrderTheyAreVisitedAgainCostNoMoreThanShuffled) {
  const test::RecordedRig rig = test::recordRig(1);
  std::vector<Pose> poses = visitedAgain(rig, 500);
  const auto evaluations = [&] {
    PosePosterior posterior(rig.model, poses, test::paperParameters(rig.model), {});
    return searchPosterior(posterior, {1, 0, 1}).front().evaluations;
  };
  const long in_order = evaluations();
  std::ranges::shuffle(poses, std::mt19937(3));
  EXPECT_LT(in_order, 2 * evaluations());
}

TEST(PosteriorSearch, OfManyPosesGoesOnFromAnyJournalToTheSameBits) {
  const test::RecordedRig rig = test::recordRig(2);
  const std::vector<Pose> poses = visitedAgain(rig, 150);
  const auto search = [&](SearchJournal& journal, int threads) {
    PosePosterior posterior(rig.model, poses, test::paperParameters(rig.model), {});
    return searchPosterior(posterior, {4, threads, 1}, journal, [](const PosteriorFit&) { return false; });
  };
  SearchJournal whole;
  const auto fits = search(whole, 1);
  ASSERT_EQ(fits.size(), 4u);
  for (const std::size_t kept : {0u, 1u, 3u}) {
    SearchJournal journal{whole.whitened_at, {whole.fits.begin(), whole.fits.begin() + kept}};
    const auto again = search(journal, 3);
    ASSERT_EQ(again.size(), fits.size()) << kept;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      EXPECT_EQ(again[i].z, fits[i].z) << kept << " " << i;
      EXPECT_EQ(again[i].objective, fits[i].objective) << kept << " " << i;
      EXPECT_EQ(again[i].evaluations, fits[i].evaluations) << kept << " " << i;
    }
  }
}

TEST(PosteriorSearch, IsTheSameForAnyNumberOfThreads) {
  const test::RecordedRig rig = test::recordRig(7);
  const ParameterSpace space = test::paperParameters(rig.model);
  std::vector<double> objectives[2];
  std::vector<Eigen::VectorXd> last;
  for (const int threads : {1, 3}) {
    PosePosterior posterior(rig.model, rig.calibration, space, {});
    const auto fits = searchPosterior(posterior, {5, threads, 1});
    ASSERT_EQ(fits.size(), 5u);
    for (const PosteriorFit& fit : fits) objectives[threads > 1].push_back(fit.objective);
    last.push_back(fits.back().z);
  }
  EXPECT_EQ(objectives[0], objectives[1]);
  EXPECT_EQ(last[0], last[1]);
}

TEST(PosteriorSearch, HybridGoesOnFromAnyJournalToTheSameBits) {
  const test::RecordedRig rig = test::recordRig(8);
  const ParameterSpace space = test::paperParameters(rig.model);
  PosePosterior posterior(rig.model, rig.calibration, space, {});
  std::vector<double> seen;
  EvolutionStrategyOptions strategy;
  strategy.mu = 3;
  strategy.lambda = 9;
  const auto note = [&](const PosteriorFit& found) {
    seen.push_back(found.objective);
    return false;
  };
  SearchJournal whole;
  searchHybrid(posterior, {3, 2, 1}, strategy, whole, note);
  ASSERT_EQ(whole.fits.size(), 3u + kHybridRounds * 3u);
  for (const std::size_t kept : {0u, 1u, 2u, 5u, 12u}) {
    SearchJournal journal{whole.whitened_at, {whole.fits.begin(), whole.fits.begin() + kept}};
    const std::vector<double> before = std::exchange(seen, {});
    PosePosterior again(rig.model, rig.calibration, space, {});
    searchHybrid(again, {3, 1, 1}, strategy, journal, note);
    EXPECT_EQ(seen, before) << kept;
    EXPECT_EQ(journal.fits.back().z, whole.fits.back().z) << kept;
  }
}

}  // namespace
}  // namespace simgap
