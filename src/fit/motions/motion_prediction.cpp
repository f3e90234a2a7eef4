#include "motion_prediction.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr std::uint32_t kPlayed = 32;  // parameters drawn, with which all motions are played
constexpr std::uint32_t kDraws = 1000;
enum Purpose : std::uint32_t { kParameters = 8, kPick, kSpread, kMean, kMotion };

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Mean squares of a motion's channel groups, shape (joints + 2): joints, shafts, currents.
using Squares = Eigen::VectorXd;

Squares squaresOf(const MotionRms& rms) {
  Squares squares(std::ssize(rms.joints) + 2);
  for (std::size_t j = 0; j < rms.joints.size(); ++j)
    squares[static_cast<Eigen::Index>(j)] = std::pow(rms.joints[j], 2);
  squares.tail<2>() << rms.shafts * rms.shafts, rms.currents * rms.currents;
  return squares;
}

/// a_m of one motion.
Squares wayBetween(const MotionResiduals& motion, const Eigen::VectorXd& here, const Eigen::VectorXd& there,
                   Eigen::Index groups) {
  Squares sums = Squares::Zero(groups), counts = Squares::Zero(groups);
  for (const ResidualBlock& block : motion.blocks()) {
    const Eigen::Index group = block.group == ChannelGroup::kJoint   ? static_cast<Eigen::Index>(block.item)
                               : block.group == ChannelGroup::kShaft ? groups - 2
                                                                     : groups - 1;
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
      played.ways.back().col(static_cast<Eigen::Index>(m)) = way;
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

std::vector<Eigen::VectorXd> drawParameters(const MotionPosterior& posterior, const Eigen::VectorXd& found,
                                            const Eigen::MatrixXd& covariance) {
  const CounterRandom random(0);
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  std::vector<Eigen::VectorXd> draws;
  for (std::uint32_t draw = 0; draw < kPlayed; ++draw) {
    Eigen::VectorXd normal(found.size());
    for (Eigen::Index i = 0; i < normal.size(); ++i) {
      normal[i] = random.normalPair({draw, static_cast<std::uint32_t>(i), 0, kParameters})[0];
    }
    Eigen::VectorXd z = found + root * normal;
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = std::clamp(z[i], posterior.lower(i), posterior.upper(i));
    draws.push_back(std::move(z));
  }
  return draws;
}

/// Draws of one channel group's root mean square over a set. \param left  exp(u) of the motions fitted
std::vector<double> drawRms(const Eigen::VectorXd& left, const std::vector<Eigen::MatrixXd>& unseen,
                            Eigen::Index group) {
  const CounterRandom random(0);
  const auto freedom = static_cast<double>(left.size() - 1);
  const Eigen::ArrayXd u = left.array().log();
  const double mean = u.mean(), squares = (u - mean).square().sum();
  const boost::math::chi_squared spread(freedom);
  const auto place = static_cast<std::uint32_t>(group);
  std::vector<double> draws;
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    const auto pick =
        static_cast<std::size_t>(random.uniform({draw, 0, 0, kPick}) * static_cast<double>(unseen.size()));
    const Eigen::MatrixXd& way = unseen[pick];
    const double sd = std::sqrt(squares / boost::math::quantile(spread, random.uniform({draw, place, 0, kSpread})));
    const double centre = mean + sd * random.normalPair({draw, place, 0, kMean})[0] / std::sqrt(freedom + 1.0);
    double sum = 0.0;
    for (Eigen::Index m = 0; m < way.cols(); ++m) {
      const auto motion = static_cast<std::uint32_t>(m);
      sum += std::exp(centre + sd * random.normalPair({draw, place, motion, kMotion})[0]) + way(group, m);
    }
    draws.push_back(std::sqrt(sum / static_cast<double>(way.cols())));
  }
  return draws;
}

}  // namespace

std::optional<MotionPrediction> predictMotions(const MotionPosterior& posterior, const MotionFit& fit, double misfit,
                                               const std::vector<MotionRms>& fitted, const MotionPosterior& unseen) {
  const auto joints = std::ssize(fitted.front().joints);
  const Eigen::Index groups = joints + 2;
  const Eigen::MatrixXd covariance = covarianceAt(misfit, posterior, fit.covariance);
  const std::vector<Eigen::VectorXd> draws = drawParameters(posterior, fit.z, covariance);
  const PlayedDraws seen = playDraws(posterior, fit.z, draws, groups),
                    held_out = playDraws(unseen, fit.z, draws, groups);
  if (fitted.size() < 2 || seen.ways.empty() || held_out.ways.empty()) return std::nullopt;

  // A fit takes no more away than as many parameters as it can tell.
  const double most = misfit * misfit * toldParameters(posterior, covariance);
  const double part = std::min(1.0, most / std::max(most, seen.weighed)) / static_cast<double>(seen.ways.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(groups, std::ssize(fitted));
  for (const Eigen::MatrixXd& way : seen.ways) left += part * way;
  for (std::size_t m = 0; m < fitted.size(); ++m) left.col(static_cast<Eigen::Index>(m)) += squaresOf(fitted[m]);
  Eigen::MatrixX3d quantiles(groups, 3);
  for (Eigen::Index group = 0; group < groups; ++group) {
    if (!(left.row(group).array() > 0.0).all()) {  // not measured
      quantiles.row(group).setConstant(kUnknown);
      continue;
    }
    const std::vector<double> rms = drawRms(left.row(group), held_out.ways, group);
    quantiles.row(group) << quantile(rms, 0.5), quantile(rms, 0.05), quantile(rms, 0.95);
  }
  const auto column = [&](Eigen::Index c) {
    const Eigen::VectorXd of_joints = quantiles.col(c).head(joints);
    return MotionRms{{of_joints.begin(), of_joints.end()}, quantiles(joints, c), quantiles(joints + 1, c)};
  };
  return MotionPrediction{column(0), column(1), column(2)};
}

}  // namespace simgap
