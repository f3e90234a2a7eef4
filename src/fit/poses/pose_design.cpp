#include "simgap/fit/poses/pose_design.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/fit/poses/posterior_search.h"

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
  /// \param targets  shape (candidates * dof, parameters): Jacobians of the joints themselves, not whitened
  GreedyDesign(const std::vector<PoseResidual>& candidates, Eigen::MatrixXd targets, DesignCriterion criterion)
      : candidates_(candidates),
        targets_(std::move(targets)),
        dof_(candidates.front().error.size()),
        criterion_(criterion) {}

  /// The candidate whose recording leaves the least; -1 when none is left.
  int best(const Eigen::MatrixXd& covariance, const std::vector<bool>& used) const {
    const Eigen::MatrixXd cross = covariance * targets_.transpose();  // C T^T, all targets side by side
    Eigen::VectorXd variance(std::ssize(candidates_));                // of the joints at r
    for (Eigen::Index r = 0; r < variance.size(); ++r) {
      variance[r] = (targets_.middleRows(r * dof_, dof_) * cross.middleCols(r * dof_, dof_)).trace();
    }
    int found = -1;
    double most = -1.0;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      if (used[c]) continue;
      stopIfInterrupted();
      const Eigen::MatrixXd& jacobian = candidates_[c].jacobian;
      const Eigen::MatrixXd innovation =
          Eigen::MatrixXd::Identity(jacobian.rows(), jacobian.rows()) + jacobian * covariance * jacobian.transpose();
      const Eigen::LLT<Eigen::MatrixXd> factor(innovation);
      const double gain = criterion_ == DesignCriterion::kInformation
                              ? 2.0 * factor.matrixLLT().diagonal().array().log().sum()
                              : errorRemoved(factor, jacobian, cross, variance);
      if (gain <= most) continue;
      most = gain;
      found = static_cast<int>(c);
    }
    return found;
  }

 private:
  /// By how much the standard deviations fall in sum: the variance at r falls by |L^-1 J_c C T_r^T|^2 with
  /// L L^T = 1 + J_c C J_c^T. A sum of variances would be ruled by the few softest poses.
  double errorRemoved(const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::MatrixXd& jacobian,
                      const Eigen::MatrixXd& cross, const Eigen::VectorXd& variance) const {
    const Eigen::MatrixXd removed = factor.matrixL().solve(jacobian * cross);
    double sum = 0.0;
    for (Eigen::Index r = 0; r < variance.size(); ++r) {
      const double less = variance[r] - removed.middleCols(r * dof_, dof_).squaredNorm();
      sum += std::sqrt(variance[r]) - std::sqrt(std::max(0.0, less));
    }
    return sum;
  }

  const std::vector<PoseResidual>& candidates_;
  Eigen::MatrixXd targets_;
  Eigen::Index dof_;
  DesignCriterion criterion_;
};

/// Muscles that are beyond their linear range in the recorded poses already.
std::string stretchedText(const PosePosterior& posterior, const Eigen::VectorXd& z) {
  const ArmModel model = posterior.modelAt(z);
  const auto outcomes = makeEquilibriumEvaluator(1)->evaluate({&model, 1}, posterior.poses(), AfterInvalid::kGoOn);
  std::string text;
  for (const StretchedCord& cord : cordsBeyondLinear(outcomes, model.muscles.size())) {
    text += fmt::format("; the recorded poses stretch the cord of {} by {:.0f} %, it is linear up to {:.0f} %",
                        model.muscles[cord.muscle].name, 100.0 * cord.expansion, 100.0 * ShockCord::kLinearRange);
  }
  return text;
}

}  // namespace

PoseDesign designPoses(PosePosterior& posterior, const Eigen::VectorXd& z, const ParameterSpace& space,
                       const DesignOptions& options) {
  const std::vector<Pose> candidates = drawCommands(posterior, z, options.candidates, options.seed);
  // Other commands judge the choice than those it was made from.
  const std::vector<Pose> unseen = drawCommands(posterior, z, 100, options.seed + 1);
  if (candidates.size() < options.poses || unseen.empty()) {
    throw NumericsError(fmt::format("only {} of {} candidate commands lead to a stable equilibrium with linear cords{}",
                                    candidates.size(), options.candidates, stretchedText(posterior, z)));
  }
  PoseUncertainty uncertainty = assessUncertainty(posterior, z, space);
  PosePosterior there(posterior, candidates);
  there.whiten(z);
  const std::vector<PoseResidual> residuals = there.evaluate(z, true);
  const Eigen::MatrixXd recorded = uncertainty.covariance;

  PoseDesign design;
  design.before = predictError(posterior, z, uncertainty, unseen);
  std::vector<bool> used;
  const Eigen::Index dof = posterior.degreesOfFreedom();
  Eigen::MatrixXd targets(std::ssize(residuals) * dof, z.size());
  for (std::size_t c = 0; c < residuals.size(); ++c) {
    used.push_back(!residuals[c].valid);
    targets.middleRows(static_cast<Eigen::Index>(c) * dof, dof) = inverse(there.whitening(c)) * residuals[c].jacobian;
  }
  const GreedyDesign greedy(residuals, std::move(targets), options.criterion);
  for (std::size_t k = 0; k < options.poses; ++k) {
    stopIfInterrupted();
    const int next = greedy.best(uncertainty.covariance, used);
    if (next < 0) break;
    used[next] = true;
    addPose(uncertainty.covariance, residuals[next].jacobian);
    design.poses.push_back(candidates[next]);
    design.after.push_back(predictError(posterior, z, uncertainty, unseen));
  }
  uncertainty.covariance = recorded;
  for (std::size_t k = 0; k < design.poses.size(); ++k) addPose(uncertainty.covariance, residuals[k].jacobian);
  design.after_random = predictError(posterior, z, uncertainty, unseen);
  return design;
}

void requireDesignable(const PoseSet& recorded) {
  if (recorded.poses.size() >= kFewestPoses) return;
  throw DataError(fmt::format("{}: found {} poses, expected at least {} to design the next ones from", recorded.file,
                              recorded.poses.size(), kFewestPoses));
}

DesignResult designNextPoses(const ArmModel& model, const PoseSet& recorded, const CalibrationConfig& config,
                             const DesignOptions& options) {
  const ParameterSpace space(model, config.parameters);
  PosePosterior posterior(model, recorded.poses, space, config.noise);
  const PosteriorSearchOptions search{.starts = config.starts, .seed = options.seed};
  const std::vector<PosteriorFit> fits = searchPosterior(posterior, search);
  stopIfInterrupted();
  const PosteriorFit& best = *std::ranges::min_element(fits, {}, &PosteriorFit::objective);
  if (std::isinf(best.objective)) throw NumericsError("no start led to stable equilibria in all recorded poses");
  posterior.whiten(best.z);
  DesignResult result{posterior.modelAt(best.z), recorded, options, designPoses(posterior, best.z, space, options), {}};
  result.expected = replayAll(*makeEvaluator("equilibrium", {}), result.model, {"next_poses.csv", result.design.poses});
  return result;
}

}  // namespace simgap
