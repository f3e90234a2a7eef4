#include "motion_prediction.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr std::uint32_t kPlayed = 32;  // parameters drawn, with which all motions are played
constexpr std::uint32_t kDraws = 1000;
constexpr std::size_t kSpreads = 200;  // tau, from well below to well above what was seen
enum Purpose : std::uint32_t { kPick = 9, kSpread, kMean, kMotion };

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Mean squares of a motion's channel groups, shape (joints + 2): joints, shafts, currents.
using Squares = Eigen::VectorXd;

Squares squaresOf(const MotionRms& rms) {
  Squares squares(std::ssize(rms.joints) + 2);
  for (std::size_t j = 0; j < rms.joints.size(); ++j) squares[j] = std::pow(rms.joints[j], 2);
  squares.tail<2>() << rms.shafts * rms.shafts, rms.currents * rms.currents;
  return squares;
}

Eigen::Index groupOf(const ResidualBlock& block, Eigen::Index groups) {
  if (block.group == ChannelGroup::kJoint) return static_cast<Eigen::Index>(block.item);
  return block.group == ChannelGroup::kShaft ? groups - 2 : groups - 1;
}

/// How many numbers were measured, shape (groups, motions).
Eigen::MatrixXd numbersOf(const MotionPosterior& posterior, Eigen::Index groups) {
  Eigen::MatrixXd numbers = Eigen::MatrixXd::Zero(groups, std::ssize(posterior.motions()));
  for (std::size_t m = 0; m < posterior.motions().size(); ++m) {
    for (const ResidualBlock& block : posterior.motions()[m].blocks()) {
      numbers(groupOf(block, groups), static_cast<Eigen::Index>(m)) +=
          static_cast<double>(block.end - block.begin) * static_cast<double>(block.size);
    }
  }
  return numbers;
}

/// a_m of one motion.
Squares wayBetween(const MotionResiduals& motion, const Eigen::VectorXd& here, const Eigen::VectorXd& there,
                   Eigen::Index groups) {
  Squares sums = Squares::Zero(groups), counts = Squares::Zero(groups);
  for (const ResidualBlock& block : motion.blocks()) {
    const Eigen::Index group = groupOf(block, groups);
    const auto rows = Eigen::seqN(block.first, block.size);
    sums[group] += block.sd * block.sd * (there(rows) - here(rows)).squaredNorm();
    counts[group] += static_cast<double>(block.size);
  }
  return sums.cwiseQuotient(counts.cwiseMax(1.0));
}

/// Motions played with parameters drawn; draws with which one cannot be played are left out.
struct PlayedDraws {
  std::vector<Eigen::MatrixXd> ways;  ///< a_m, shape (draws) of (groups, motions)
  double weighed = 0.0;               ///< |f(z) - f(z_found)|^2 as residuals are weighed, the mean over draws
};

PlayedDraws playDraws(const MotionPosterior& motions, const Eigen::VectorXd& found,
                      const std::vector<Eigen::VectorXd>& draws, Eigen::Index groups) {
  PlayedDraws played;
  const MotionEvaluation here = motions.evaluate(found);
  for (const Eigen::VectorXd& z : draws) {
    const MotionEvaluation there = motions.evaluate(z);
    stopIfInterrupted();
    if (!here.valid || !there.valid) continue;
    played.ways.emplace_back(groups, std::ssize(motions.motions()));
    for (std::size_t m = 0; m < motions.motions().size(); ++m) {
      const Squares way = wayBetween(motions.motions()[m], here.residuals[m], there.residuals[m], groups);
      played.ways.back().col(m) = way;
      played.weighed += (there.residuals[m] - here.residuals[m]).squaredNorm();
    }
  }
  played.weighed /= std::max(1.0, static_cast<double>(played.ways.size()));
  return played;
}

/// Covariance where residuals have misfit^2 times the variance that their weights assume: the information is that much
/// less, or more; the prior is what it was.
Eigen::MatrixXd covarianceAt(double misfit, const MotionPosterior& posterior, const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = covariance.rows();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd prior(n);
  for (Eigen::Index i = 0; i < n; ++i) prior[i] = posterior.hasPrior(i) ? 1.0 : 0.0;
  Eigen::MatrixXd curvature = covariance.ldlt().solve(identity);
  curvature.diagonal() -= prior;
  curvature /= misfit * misfit;
  curvature.diagonal() += prior;
  return curvature.ldlt().solve(identity);
}

/// How many parameters the motions tell: the trace of the matrix that takes measured numbers to fitted ones.
double toldParameters(const MotionPosterior& posterior, const Eigen::MatrixXd& covariance) {
  double told = 0.0;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    told += posterior.hasPrior(i) ? std::max(0.0, 1.0 - covariance(i, i)) : 1.0;
  }
  return told;
}

/// What is known of u over motions: for each tau its probability and, under it, mean and variance of u's centre.
struct LeftOver {
  std::vector<double> tau, until, centre, variance;  ///< shape (kSpreads); until: probability of this tau or a smaller

  /// \param left  exp(u) of the motions fitted  \param noise  variance of u that noise alone makes, of each
  LeftOver(const Eigen::ArrayXd& left, const Eigen::ArrayXd& noise) {
    const Eigen::ArrayXd u = left.log();
    const double scatter = (u - u.mean()).square().sum() / static_cast<double>(u.size() - 1);
    const double scale = std::sqrt(std::max(scatter, noise.mean()));
    std::vector<double> log_density;
    for (std::size_t k = 0; k < kSpreads; ++k) {
      const double x = (static_cast<double>(k) + 0.5) / kSpreads;  // evenly from 0 to 1
      tau.push_back(scale * x / (1.0 - x));
      const double squared = tau.back() * tau.back();
      const Eigen::ArrayXd weight = (noise + squared).inverse();
      variance.push_back(1.0 / weight.sum());
      centre.push_back(variance.back() * (weight * u).sum());
      const double log_likelihood =
          0.5 * (weight.log().sum() + std::log(variance.back()) - (weight * (u - centre.back()).square()).sum());
      const double log_prior = -0.5 * std::log(squared + noise.mean()), log_slope = -2.0 * std::log(1.0 - x);
      log_density.push_back(log_likelihood + log_prior + log_slope);
    }
    const double highest = *std::ranges::max_element(log_density);
    for (const double log : log_density) until.push_back(std::exp(log - highest));
    std::partial_sum(until.begin(), until.end(), until.begin());
  }

  std::size_t pick(double uniform) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(until, uniform * until.back()) - until.begin());
  }
};

/// Draws of one channel group's root mean square over a set. \param unseen  a_m of its motions, shape (draws) of
/// (groups, motions)  \param numbers  measured in each motion of the set, shape (motions)
std::vector<double> drawRms(const LeftOver& left, const std::vector<Eigen::MatrixXd>& unseen,
                            const Eigen::VectorXd& numbers, Eigen::Index group) {
  const CounterRandom random(0);
  const auto place = static_cast<std::uint32_t>(group);
  std::vector<double> draws;
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    const auto pick =
        static_cast<std::size_t>(random.uniform({draw, 0, 0, kPick}) * static_cast<double>(unseen.size()));
    const std::size_t k = left.pick(random.uniform({draw, place, 0, kSpread}));
    const double centre = left.centre[k] + std::sqrt(left.variance[k]) * random.normalPair({draw, place, 0, kMean})[0];
    double sum = 0.0;
    for (Eigen::Index m = 0; m < numbers.size(); ++m) {
      if (numbers[m] == 0.0) continue;
      const double sd = std::sqrt(left.tau[k] * left.tau[k] + 2.0 / numbers[m]);
      const auto motion = static_cast<std::uint32_t>(m);
      sum += numbers[m] *
             (std::exp(centre + sd * random.normalPair({draw, place, motion, kMotion})[0]) + unseen[pick](group, m));
    }
    draws.push_back(std::sqrt(sum / numbers.sum()));
  }
  return draws;
}

}  // namespace

std::optional<MotionPrediction> predictMotions(const MotionPosterior& posterior, const MotionFit& fit, double misfit,
                                               const std::vector<MotionRms>& fitted, const MotionPosterior& unseen) {
  if (fitted.size() < 2) return std::nullopt;
  const auto joints = std::ssize(fitted.front().joints);
  const Eigen::Index groups = joints + 2;
  const Eigen::MatrixXd covariance = covarianceAt(misfit, posterior, fit.covariance);
  const std::vector<Eigen::VectorXd> draws = posterior.draws(fit.z, covariance, kPlayed);
  const PlayedDraws seen = playDraws(posterior, fit.z, draws, groups),
                    held_out = playDraws(unseen, fit.z, draws, groups);
  if (seen.ways.empty() || held_out.ways.empty()) return std::nullopt;

  // A fit takes no more away than as many parameters as it can tell.
  const double most = misfit * misfit * toldParameters(posterior, covariance);
  const double part = std::min(1.0, most / std::max(most, seen.weighed)) / static_cast<double>(seen.ways.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(groups, std::ssize(fitted));
  for (const Eigen::MatrixXd& way : seen.ways) left += part * way;
  for (std::size_t m = 0; m < fitted.size(); ++m) left.col(m) += squaresOf(fitted[m]);
  const Eigen::MatrixXd numbers = numbersOf(posterior, groups), numbers_unseen = numbersOf(unseen, groups);
  Eigen::MatrixX3d quantiles(groups, 3);
  for (Eigen::Index group = 0; group < groups; ++group) {
    if (!(left.row(group).array() > 0.0).all() || numbers_unseen.row(group).sum() == 0.0) {  // not measured
      quantiles.row(group).setConstant(kUnknown);
      continue;
    }
    const LeftOver of_group(left.row(group).transpose(), 2.0 / numbers.row(group).transpose().array());
    const std::vector<double> rms = drawRms(of_group, held_out.ways, numbers_unseen.row(group), group);
    quantiles.row(group) << quantile(rms, 0.5), quantile(rms, 0.05), quantile(rms, 0.95);
  }
  const auto column = [&](Eigen::Index c) {
    const Eigen::VectorXd of_joints = quantiles.col(c).head(joints);
    return MotionRms{{of_joints.begin(), of_joints.end()}, quantiles(joints, c), quantiles(joints + 1, c)};
  };
  return MotionPrediction{column(0), column(1), column(2)};
}

}  // namespace simgap
