#include "pose_validation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

namespace simgap {
namespace {

constexpr std::size_t kPoseFolds = 5;

}  // namespace

PoseFolds::PoseFolds(std::span<const Pose> poses) : folds_(kPoseFolds), poses_(poses.size()) {
  for (std::size_t p = 0; p < poses.size(); ++p) {
    for (std::size_t f = 0; f < kPoseFolds; ++f) {
      (p % kPoseFolds == f ? folds_[f].validation : folds_[f].training).push_back(poses[p]);
    }
    folds_[p % kPoseFolds].validation_index.push_back(p);
  }
}

CrossValidation PoseFolds::validate(const PoseProblem& problem, const std::vector<ArmCause>& causes,
                                    const Eigen::VectorXd& z, const std::vector<ArmCause>& like,
                                    const Eigen::VectorXd& z_like) const {
  CrossValidation result;
  result.distances.resize(poses_);
  std::vector<double> expected(kPoseFolds);
  /// The distances of a fold's poses, and behind them what is expected of their sum.
  const auto validateFold = [&](std::size_t f) {
    const Fold& fold = folds_[f];
    PoseFit whitening(problem, fold.training, like);
    whitening.posterior().whiten(z_like);
    whitening.setSolution(z_like);
    PoseFit fit(problem, fold.training, causes);
    fit.posterior().whitenLike(whitening.posterior());
    fit.descend(z);
    std::vector<double> unseen = unseenDistances(fit, problem, fold.validation, whitening);
    double sum = 0.0;
    const Eigen::LLT<Eigen::MatrixXd> curvature(fit.curvature());
    PoseFit there(problem, fold.validation, causes);
    there.posterior().whiten(fit.z());
    for (const PoseResidual& pose : there.posterior().evaluate(fit.z(), true)) {
      const Eigen::MatrixXd left = curvature.matrixL().solve(pose.jacobian.transpose());
      sum += static_cast<double>(pose.error.size()) + left.squaredNorm();
    }
    unseen.push_back(sum);
    return unseen;
  };
  forEachOnRanks(problem, kPoseFolds, z, validateFold, [&](std::size_t f, std::vector<double> unseen) {
    if (unseen.empty()) return;  // interrupted
    expected[f] = unseen.back();
    for (std::size_t i = 0; i + 1 < unseen.size(); ++i) {
      result.distances[folds_[f].validation_index[i]] = robustLoss(unseen[i]);
    }
  });
  result.expected = std::accumulate(expected.begin(), expected.end(), 0.0);
  return result;
}

}  // namespace simgap
