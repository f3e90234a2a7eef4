#include "pose_weighing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/optimize/bundle_descent.h"

namespace simgap {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kEnough = 0.01;  // of the log posterior, by which it may still be bettered

/// Phi(z, u) about the candidate's fit to the poses before; x = (z - z0, u).
class BeforeAndAfter {
 public:
  BeforeAndAfter(PoseFit& before, PoseFit& after, const VectorXd& z_after, std::span<const Index> undone,
                 const MatrixXd& uncertain)
      : before_(before),
        after_(after),
        z_before_(before.z()),
        z_after_(z_after),
        moved_(VectorXd::Ones(z_after.size())),
        uncertain_(uncertain.size() > 0
                       ? uncertain
                       : MatrixXd(after.posterior().degreesOfFreedom() * std::ssize(after.posterior().poses()), 0)) {
    for (const Index i : undone) moved_[i] = 0.0;  // what the change has undone is known to be nothing
  }

  Index size() const { return z_before_.size() + uncertain_.cols(); }

  double objective(const VectorXd& x) const {
    const double before = before_.posterior().objective(z_before_ + x.head(z_before_.size()));
    const VectorXd e = distancesAfter(x, false);
    return before + 0.5 * e.squaredNorm() + 0.5 * x.tail(uncertain_.cols()).squaredNorm();
  }

  /// Gauss-Newton's curvature and the gradient.
  void linearise(const VectorXd& x, MatrixXd& curvature, VectorXd& gradient) const {
    const Index n = z_before_.size(), m = uncertain_.cols();
    before_.setSolution(z_before_ + x.head(n));
    curvature = MatrixXd::Identity(n + m, n + m);
    curvature.topLeftCorner(n, n) = before_.curvature();
    gradient = x;
    gradient.head(n) = before_.gradient();
    const VectorXd e = distancesAfter(x, true);
    curvature += jacobian_.transpose() * jacobian_;
    gradient += jacobian_.transpose() * e;
  }

  KinkedFunction function() const {
    const ScaledParameters& parameters = before_.posterior().parameters();
    constexpr double kNone = std::numeric_limits<double>::infinity();
    KinkedFunction f{
        [this](const VectorXd& x) { return objective(x); },
        [this](const VectorXd& x, MatrixXd& curvature, VectorXd& slope) { linearise(x, curvature, slope); },
        VectorXd::Constant(size(), -kNone), VectorXd::Constant(size(), kNone)};
    for (Index i = 0; i < z_before_.size(); ++i) {
      f.lower[i] = std::min(0.0, parameters.lower(i) - z_before_[i]);
      f.upper[i] = std::max(0.0, parameters.upper(i) - z_before_[i]);
    }
    return f;
  }

  /// Of the poses before alone, shape (parameters, parameters).
  MatrixXd curvatureBefore(const VectorXd& x) const {
    before_.setSolution(z_before_ + x.head(z_before_.size()));
    return before_.curvature();
  }

 private:
  VectorXd distancesAfter(const VectorXd& x, bool jacobians) const {
    const VectorXd z = z_after_ + moved_.cwiseProduct(x.head(z_before_.size()));
    const std::vector<PoseResidual>& residuals = after_.posterior().evaluate(z, jacobians);
    const Index dof = after_.posterior().degreesOfFreedom();
    VectorXd e = VectorXd::Constant(dof * std::ssize(residuals), kOutOfReach);
    if (jacobians) jacobian_ = MatrixXd::Zero(e.size(), size());
    for (std::size_t p = 0; p < residuals.size(); ++p) {
      if (!residuals[p].valid) continue;
      const Index at = dof * static_cast<Index>(p);
      e.segment(at, dof) = residuals[p].error;
      if (jacobians) jacobian_.block(at, 0, dof, z.size()) = residuals[p].jacobian * moved_.asDiagonal();
    }
    if (jacobians) jacobian_.rightCols(uncertain_.cols()) = uncertain_;
    return e + uncertain_ * x.tail(uncertain_.cols());
  }

  PoseFit& before_;
  PoseFit& after_;
  VectorXd z_before_, z_after_, moved_;
  MatrixXd uncertain_;
  mutable MatrixXd jacobian_;  ///< of e by x, shape (components, parameters and uncertain numbers)
};

double halfLogDeterminant(const MatrixXd& curvature) {
  return curvature.llt().matrixLLT().diagonal().array().log().sum();
}

}  // namespace

Weighed weighAfter(const PoseEvidence& evidence, const CandidateModel& candidate, const ArmChanges& change,
                   std::span<const Pose> after, const MatrixXd& uncertain) {
  const std::vector<ArmCause> causes = causesBeyond(evidence.given, candidate.model);
  PoseFit before(problemOf(evidence, candidate), evidence.poses, causes);
  // The poses are whitened as the candidate is; under another whitening it was not quite the optimum.
  const VectorXd z = solutionOf(before, candidate.model);
  before.posterior().whiten(z);
  before.descend(z);
  const double phi = before.objective();
  if (!std::isfinite(phi)) {
    throw NumericsError(
        fmt::format("{}: this model has no equilibrium for some pose before the change", candidate.causes));
  }

  PoseProblem changed = problemOf(evidence, candidate);
  change.apply(changed.nominal);
  ArmModel model = before.model();
  change.apply(model);
  PoseFit there(changed, after, causes);
  const VectorXd z_after = solutionOf(there, model);
  there.posterior().whiten(z_after);

  const BeforeAndAfter both(before, there, z_after, undoneParameters(there, change), uncertain);
  const BundleDescent optimum = descendBundle(both.function(), VectorXd::Zero(both.size()), kEnough);
  const double scale = 1.0 + std::max(0.0, evidence.excess);
  Weighed result;
  result.distance = 2.0 * std::max(0.0, optimum.value - phi) / scale;
  double whitening = 0.0;
  for (std::size_t p = 0; p < after.size(); ++p) {
    whitening += there.posterior().whitening(p).diagonal().array().log().sum();
  }
  const double components =
      static_cast<double>(there.posterior().degreesOfFreedom()) * static_cast<double>(after.size());
  result.log_likelihood = whitening + halfLogDeterminant(both.curvatureBefore(optimum.x)) -
                          halfLogDeterminant(optimum.curvature) - 0.5 * components * std::log(scale) -
                          0.5 * result.distance;
  return result;
}

}  // namespace simgap
