#include "simgap/fit/pose_design.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// Covariance after a pose with whitened Jacobian J was recorded: C - C J^T (1 + J C J^T)^-1 J C.
void addPose(Eigen::MatrixXd& covariance, const Eigen::MatrixXd& jacobian) {
  const Eigen::MatrixXd gain = covariance * jacobian.transpose();
  const Eigen::MatrixXd innovation = Eigen::MatrixXd::Identity(jacobian.rows(), jacobian.rows()) + jacobian * gain;
  covariance -= gain * innovation.llt().solve(gain.transpose());
}

class GreedyDesign {
 public:
  /// \param targets  shape (candidates): Jacobians of the joints themselves, not whitened
  GreedyDesign(const std::vector<PoseResidual>& candidates, std::vector<Eigen::MatrixXd> targets,
               DesignCriterion criterion)
      : candidates_(candidates), targets_(std::move(targets)), criterion_(criterion) {}

  /// The candidate whose recording leaves the least; -1 when none is left.
  int best(const Eigen::MatrixXd& covariance, const std::vector<bool>& used) const {
    // The variance of T_r z falls by |L^-1 J_c C T_r^T|^2 with L L^T = 1 + J_c C J_c^T.
    std::vector<Eigen::MatrixXd> cross(candidates_.size());
    for (std::size_t c = 0; c < candidates_.size(); ++c) cross[c] = covariance * targets_[c].transpose();
    int found = -1;
    double most = -1.0;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      if (used[c]) continue;
      const Eigen::MatrixXd& jacobian = candidates_[c].jacobian;
      const Eigen::LLT<Eigen::MatrixXd> innovation(Eigen::MatrixXd::Identity(jacobian.rows(), jacobian.rows()) +
                                                   jacobian * covariance * jacobian.transpose());
      const double gain = criterion_ == DesignCriterion::kInformation
                              ? 2.0 * innovation.matrixLLT().diagonal().array().log().sum()
                              : varianceRemoved(innovation, jacobian, cross);
      if (gain <= most) continue;
      most = gain;
      found = static_cast<int>(c);
    }
    return found;
  }

 private:
  double varianceRemoved(const Eigen::LLT<Eigen::MatrixXd>& innovation, const Eigen::MatrixXd& jacobian,
                         const std::vector<Eigen::MatrixXd>& cross) const {
    double sum = 0.0;
    for (const Eigen::MatrixXd& there : cross) sum += innovation.matrixL().solve(jacobian * there).squaredNorm();
    return sum;
  }

  const std::vector<PoseResidual>& candidates_;
  std::vector<Eigen::MatrixXd> targets_;
  DesignCriterion criterion_;
};

}  // namespace

PoseDesign designPoses(PosePosterior& posterior, const Eigen::VectorXd& z, const ParameterSpace& space,
                       const DesignOptions& options) {
  const std::vector<Pose> candidates = drawCommands(posterior, z, options.candidates, options.seed);
  // Other commands judge the choice than those it was made from.
  const std::vector<Pose> unseen = drawCommands(posterior, z, 100, options.seed + 1);
  if (candidates.size() < options.poses || unseen.empty()) {
    throw NumericsError(fmt::format("only {} of {} candidate commands lead to a stable equilibrium with linear cords",
                                    candidates.size(), options.candidates));
  }
  Uncertainty uncertainty = assessUncertainty(posterior, z, space);
  PosePosterior there(posterior, candidates);
  there.whiten(z);
  const std::vector<PoseResidual> residuals = there.evaluate(z, true);
  const Eigen::MatrixXd recorded = uncertainty.covariance;

  PoseDesign design;
  design.before = predictError(posterior, z, uncertainty, unseen);
  std::vector<bool> used;
  std::vector<Eigen::MatrixXd> targets;
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    used.push_back(!residuals[c].valid);
    targets.push_back(there.whitening(c).inverse() * residuals[c].jacobian);
  }
  const GreedyDesign greedy(residuals, std::move(targets), options.criterion);
  for (std::size_t k = 0; k < options.poses; ++k) {
    const int next = greedy.best(uncertainty.covariance, used);
    if (next < 0) break;
    used[static_cast<std::size_t>(next)] = true;
    addPose(uncertainty.covariance, residuals[static_cast<std::size_t>(next)].jacobian);
    design.poses.push_back(candidates[static_cast<std::size_t>(next)]);
    design.after.push_back(predictError(posterior, z, uncertainty, unseen));
  }
  uncertainty.covariance = recorded;
  for (std::size_t k = 0; k < design.poses.size(); ++k) addPose(uncertainty.covariance, residuals[k].jacobian);
  design.after_random = predictError(posterior, z, uncertainty, unseen);
  return design;
}

}  // namespace simgap
