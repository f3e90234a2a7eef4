#include "pose_prediction.h"

#include <algorithm>

#include "simgap/core/joint_kind.h"
#include "simgap/core/random.h"

namespace simgap {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

PoseProblem problemOf(const PoseEvidence& evidence, const CandidateModel& candidate) {
  return {evidence.given, evidence.parameters, evidence.noise, evidence.threads, candidate.stray_friction};
}

std::vector<Index> undoneParameters(const PoseFit& fit, const ArmChanges& change) {
  std::vector<Index> undone;
  auto parameter = static_cast<Index>(fit.ordinary());
  for (const ArmCause& cause : fit.causes()) {
    for (const ArmEffectParameter& p : cause.effect->parameters) {
      if (p.fitted && change.undoes(cause.label())) undone.push_back(parameter);
      parameter += p.fitted ? 1 : 0;
    }
  }
  return undone;
}

VectorXd solutionOf(PoseFit& fit, const ArmModel& model) {
  return fit.posterior().parameters().scaled(fit.space().values(model));
}

PosePrediction::PosePrediction(const PoseEvidence& evidence, const CandidateModel& candidate)
    : evidence_(evidence), candidate_(candidate), causes_(causesBeyond(evidence.given, candidate.model)) {
  learnPosterior();
}

Predicted PosePrediction::after(const ArmChanges& change, std::span<const Pose> poses) const {
  Predicted result = predict(change, poses, true);
  const auto uncertain = withinUncertainty(change);
  result.uncertain.resize(result.e.size(), std::ssize(uncertain));
  for (std::size_t k = 0; k < uncertain.size(); ++k) {
    const auto& [forward, back] = uncertain[k];
    result.uncertain.col(k) =
        0.5 * (predict(forward, poses, false, &result).e - predict(back, poses, false, &result).e);
  }
  result.covariance += result.uncertain * result.uncertain.transpose();
  result.covariance *= 1.0 + std::max(0.0, evidence_.excess);
  return result;
}

std::optional<std::vector<Pose>> PosePrediction::recorded(std::span<const Pose> commands, std::uint64_t seed,
                                                          std::uint32_t draw) const {
  constexpr std::uint32_t kPurpose = 72;
  const CounterRandom random(seed);
  const auto normals = [&](std::uint32_t place, Index count) {
    VectorXd drawn(count);
    for (Index i = 0; i < count; ++i) {
      drawn[i] = random.normalPair({draw, place, static_cast<std::uint32_t>(i), kPurpose})[0];
    }
    return drawn;
  };
  PoseFit fit(problemOf(evidence_, candidate_), commands, causes_);
  PosePosterior& posterior = fit.posterior();
  const VectorXd expected = solutionOf(fit, candidate_.model);
  posterior.whiten(expected);
  VectorXd z = expected + curvature_.matrixU().solve(normals(0, expected.size()));  // of covariance N^-1
  for (Index i = 0; i < z.size(); ++i) {
    z[i] = std::clamp(z[i], posterior.parameters().lower(i), posterior.parameters().upper(i));
  }
  const std::vector<PoseResidual>& residuals = posterior.evaluate(z, false);
  std::vector<Pose> poses(commands.begin(), commands.end());
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (!residuals[p].valid) return std::nullopt;
    const VectorXd e = residuals[p].error + normals(static_cast<std::uint32_t>(p + 1), residuals[p].error.size());
    const VectorXd way = posterior.whitening(p).triangularView<Eigen::Lower>().solve(e);
    Index at = 0;
    for (std::size_t j = 0; j < poses[p].joints.size(); ++j) {
      const Joint& joint = evidence_.given.joints[j];
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      step.head(joint.degreesOfFreedom()) = way.segment(at, joint.degreesOfFreedom());
      at += joint.degreesOfFreedom();
      poses[p].joints[j] = kindOf(joint.type).moved(poses[p].joints[j], step);
    }
  }
  return poses;
}

void PosePrediction::learnPosterior() {
  PoseFit fit(problemOf(evidence_, candidate_), evidence_.poses, causes_);
  const VectorXd z = solutionOf(fit, candidate_.model);
  fit.posterior().whiten(z);
  fit.setSolution(z);
  curvature_.compute(fit.curvature());
  // The poses determine tr(N^-1 J^T J) = n - tr(N^-1 P) parameters, P: 1 where there is a prior.
  const VectorXd variances = curvature_.solve(MatrixXd::Identity(z.size(), z.size())).diagonal();
  double determined = static_cast<double>(z.size());
  for (Index i = 0; i < z.size(); ++i) determined -= fit.posterior().parameters().hasPrior(i) ? variances[i] : 0.0;
  const auto residuals = static_cast<double>(fit.posterior().degreesOfFreedom() * std::ssize(evidence_.poses));
  known_ = std::max(1.0, residuals - determined);
}

Predicted PosePrediction::predict(const ArmChanges& change, std::span<const Pose> poses, bool jacobians,
                                  const Predicted* like) const {
  PoseProblem changed = problemOf(evidence_, candidate_);
  change.apply(changed.nominal);
  ArmModel model = candidate_.model;
  change.apply(model);
  PoseFit fit(changed, poses, causes_);
  const VectorXd z = solutionOf(fit, model);
  fit.posterior().whiten(z);
  Predicted result;
  result.dof = fit.posterior().degreesOfFreedom();
  result.known = known_;
  const Index n = result.dof * std::ssize(poses);
  result.e = VectorXd::Zero(n);
  MatrixXd left = MatrixXd::Zero(z.size(), jacobians ? n : 0);
  const std::vector<PoseResidual>& residuals = fit.posterior().evaluate(z, jacobians);
  for (std::size_t p = 0; p < residuals.size(); ++p) {
    const PoseResidual& residual = residuals[p];
    const MatrixXd own = fit.posterior().whitening(p);
    const Index at = result.dof * static_cast<Index>(p);
    result.valid.push_back(residual.valid);
    result.whitening.push_back(own);
    VectorXd raw = VectorXd::Zero(result.dof);
    if (residual.valid) raw = own.triangularView<Eigen::Lower>().solve(residual.error);
    result.raw.push_back(raw);
    const MatrixXd& whitening = like != nullptr ? like->whitening[p] : own;
    result.e.segment(at, result.dof) =
        residual.valid ? VectorXd(whitening * raw) : VectorXd::Constant(result.dof, kOutOfReach);
    if (jacobians && residual.valid) left.middleCols(at, result.dof) = residual.jacobian.transpose();
  }
  for (const Index i : undoneParameters(fit, change)) left.row(i).setZero();
  if (jacobians) {
    curvature_.matrixL().solveInPlace(left);
    result.spread = left.transpose();
    result.covariance = MatrixXd::Identity(n, n) + left.transpose() * left;
  }
  return result;
}

}  // namespace simgap
