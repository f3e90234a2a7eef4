// How well the numbers of a search over motions are known where it ended.
#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/fit/motions/motion_search.h"

namespace simgap {
namespace {

/// How much wider than Laplace's the standard deviations are when residuals that last are counted as they are: the sum
/// over seconds of all motions of the scores' outer products between two inverse curvatures (White 1980, with blocks).
Eigen::VectorXd widening(const MotionPosterior& posterior, const MotionEvaluation& at,
                         const std::vector<RowMajorF>& jacobians, const Eigen::MatrixXd& covariance) {
  constexpr double kBlock = 1.0;  // [s]
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(covariance.rows());
  for (std::size_t m = 0; m < at.residuals.size(); ++m) {
    const Eigen::VectorXd pull = posterior.weights(m, at.residuals[m]).cwiseProduct(at.residuals[m]);
    std::map<long, Eigen::VectorXd> scores;
    for (const ResidualBlock& block : posterior.motions()[m].blocks()) {
      Eigen::VectorXd& score = scores[std::lround(std::floor(block.time / kBlock))];
      if (score.size() == 0) score = Eigen::VectorXd::Zero(covariance.rows());
      for (Eigen::Index row = block.first; row < block.first + block.size; ++row) {
        score += pull[row] * jacobians[m].row(row).transpose().cast<double>();
      }
    }
    for (const auto& [second, score] : scores) variance += (covariance * score).cwiseAbs2();
  }
  return (variance.cwiseQuotient(covariance.diagonal())).cwiseSqrt().cwiseMax(1.0);
}

}  // namespace

double meanSquareOf(const MotionPosterior& posterior, const MotionEvaluation& at) {
  double squares = 0.0, numbers = 0.0;
  for (std::size_t m = 0; m < at.residuals.size(); ++m) {
    const double weight = posterior.motions()[m].motion().weight;
    squares += posterior.weights(m, at.residuals[m]).dot(at.residuals[m].cwiseAbs2()) / weight;
    numbers += static_cast<double>(at.residuals[m].size());
  }
  return squares / numbers;
}

Eigen::VectorXd deviationsOf(const MotionPosterior& posterior, const MotionEvaluation& at,
                             const std::vector<RowMajorF>& jacobians, const Eigen::MatrixXd& covariance,
                             const Eigen::VectorXd& step_left) {
  const Eigen::VectorXd laplace = covariance.diagonal().cwiseSqrt();
  const double misfit = std::sqrt(std::max(1.0, meanSquareOf(posterior, at)));
  Eigen::VectorXd sd = misfit * widening(posterior, at, jacobians, covariance).cwiseProduct(laplace);
  for (Eigen::Index i = 0; i < sd.size(); ++i) {
    sd[i] = std::hypot(sd[i], step_left[i]);
    if (posterior.hasPrior(i)) sd[i] = std::min(1.0, sd[i]);
  }
  return sd;
}

}  // namespace simgap
