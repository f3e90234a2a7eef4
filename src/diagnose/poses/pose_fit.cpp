#include "pose_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/fit/poses/posterior_search.h"
#include "simgap/optimize/bundle_descent.h"

namespace simgap {
namespace {

constexpr double kUnbounded = 1e-9;     // curvature, in prior units, of what nothing bounds
constexpr double kNoEquilibrium = 1e4;  // d_p^2 of a pose the model cannot take

ArmModel priorModel(const PoseProblem& problem, const std::vector<ArmCause>& causes) {
  ArmModel model = withCauses(problem.nominal, causes);
  for (Joint& joint : model.joints) joint.coulomb_friction *= problem.stray_friction;
  return model;
}

}  // namespace

PoseFit::PoseFit(const PoseProblem& problem, std::span<const Pose> poses, std::vector<ArmCause> causes)
    : prior_(priorModel(problem, causes)),
      nominal_joints_(problem.nominal.joints),
      causes_(std::move(causes)),
      space_(prior_, choicesWith(problem.parameters, causes_, sizesOf(problem.nominal))),
      posterior_(prior_, poses, space_, problem.noise),
      ordinary_(space_.size()),
      z_(Eigen::VectorXd::Zero(space_.size())) {
  for (const ArmCause& cause : causes_) ordinary_ -= static_cast<std::size_t>(fittedParameters(*cause.effect));
}

ArmModel PoseFit::model() const {
  ArmModel model = posterior_.modelAt(z_);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    model.joints[j].coulomb_friction = nominal_joints_[j].coulomb_friction;
  }
  return model;
}

Eigen::VectorXd PoseFit::extended(const Eigen::VectorXd& z) const {
  Eigen::VectorXd all(z_.size());
  Eigen::Index i = static_cast<Eigen::Index>(ordinary_);
  all.head(i) = z.head(i);
  for (const ArmCause& cause : causes_) {
    for (std::size_t k = 0; k < cause.effect->parameters.size(); ++k) {
      if (!cause.effect->parameters[k].fitted) continue;
      all[i] = i < z.size() ? z[i] : posterior_.parameters().scaled(i, cause.start[k]);
      ++i;
    }
  }
  return all;
}

Eigen::VectorXd PoseFit::solutionWithout(std::size_t cause) const {
  auto first = static_cast<Eigen::Index>(ordinary_);
  for (std::size_t c = 0; c < cause; ++c) first += fittedParameters(*causes_[c].effect);
  const Eigen::Index gone = fittedParameters(*causes_[cause].effect);
  Eigen::VectorXd rest(z_.size() - gone);
  rest << z_.head(first), z_.tail(z_.size() - first - gone);
  return rest;
}

void PoseFit::descend(const Eigen::VectorXd& z, double tolerance) {
  constexpr int kIterations = 60;
  const PosteriorFit fit = descendPosterior(posterior_, z, kIterations, tolerance);
  z_ = fit.z;
  objective_ = fit.objective;
  followKinks();
}

/// Where a line is about to become slack the objective has a kink, and Levenberg-Marquardt's steps end there.
void PoseFit::followKinks() {
  constexpr double kEnough = 0.01;  // of the log posterior
  if (!std::isfinite(objective_) || interruptRequested()) return;
  KinkedFunction f{[&](const Eigen::VectorXd& x) { return posterior_.objective(x); },
                   [&](const Eigen::VectorXd& x, Eigen::MatrixXd& curvature, Eigen::VectorXd& slope) {
                     z_ = x;
                     curvature = this->curvature();
                     slope = gradient();
                   },
                   z_, z_};
  for (Eigen::Index i = 0; i < z_.size(); ++i) {
    f.lower[i] = std::min(z_[i], posterior_.parameters().lower(i));
    f.upper[i] = std::max(z_[i], posterior_.parameters().upper(i));
  }
  const BundleDescent found = descendBundle(f, Eigen::VectorXd(z_), kEnough);
  z_ = found.x;
  objective_ = found.value;
}

bool PoseFit::search(int starts, int threads, std::uint64_t seed) {
  PosteriorFit best;
  best.objective = std::numeric_limits<double>::infinity();
  for (const PosteriorFit& fit : searchPosterior(posterior_, {starts, threads, seed})) {
    if (fit.objective < best.objective) best = fit;
  }
  // A pose that was read wrong can carry every balance of torques to where the arm has no rest; the file's own values
  // may have one.
  if (std::isinf(best.objective)) best.z = Eigen::VectorXd::Zero(z_.size());
  posterior_.whiten(best.z);
  const std::vector<PoseResidual>& poses = posterior_.evaluate(best.z, false);
  if (!std::ranges::all_of(poses, &PoseResidual::valid)) return false;
  descend(best.z);
  return true;
}

std::vector<bool> PoseFit::withoutEquilibrium() {
  PosePosterior balancing = posterior_;
  const Eigen::VectorXd z = balanceTorques(balancing, Eigen::VectorXd::Zero(z_.size()));
  std::vector<bool> without;
  for (const PoseResidual& pose : balancing.evaluate(z, false)) without.push_back(!pose.valid);
  return without;
}

Eigen::MatrixXd PoseFit::curvature() {
  const ScaledParameters& scaled = posterior_.parameters();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(z_.size(), z_.size());
  for (Eigen::Index i = 0; i < z_.size(); ++i) sum(i, i) = scaled.hasPrior(i) ? 1.0 : kUnbounded;
  for (const PoseResidual& pose : linearised()) {
    if (!pose.valid) continue;
    sum.selfadjointView<Eigen::Lower>().rankUpdate(pose.jacobian.transpose(), robustWeight(pose.error.squaredNorm()));
  }
  return sum.selfadjointView<Eigen::Lower>();
}

Eigen::VectorXd PoseFit::gradient() {
  Eigen::VectorXd sum = z_;
  for (Eigen::Index i = 0; i < z_.size(); ++i) sum[i] *= posterior_.parameters().hasPrior(i) ? 1.0 : 0.0;
  for (const PoseResidual& pose : linearised()) {
    if (pose.valid) sum += robustWeight(pose.error.squaredNorm()) * (pose.jacobian.transpose() * pose.error);
  }
  return sum;
}

double PoseFit::logEvidence() {
  if (!std::isfinite(objective_)) return -std::numeric_limits<double>::infinity();
  double density = 0.0;  // of the poses' errors: the determinant of their whitening
  for (std::size_t p = 0; p < posterior_.poses().size(); ++p) {
    density += posterior_.whitening(p).diagonal().array().log().sum();  // triangular
  }
  double prior = 0.0;
  for (Eigen::Index i = 0; i < z_.size(); ++i) {
    prior += posterior_.parameters().hasPrior(i) ? 0.5 * z_[i] * z_[i] : 0.0;
  }
  // Of normal errors the robust loss is too small a part, by which the noise would look smaller than it is.
  const double misfit = robustConsistency(static_cast<int>(posterior_.degreesOfFreedom())) * (objective_ - prior);
  const Eigen::LLT<Eigen::MatrixXd> factor(curvature());
  return density - misfit - prior - factor.matrixLLT().diagonal().array().log().sum();
}

std::vector<Extension> PoseFit::extensions() {
  const Eigen::MatrixXd covariance = curvature().llt().solve(Eigen::MatrixXd::Identity(z_.size(), z_.size()));
  std::vector<Extension> found = model().extensions;
  auto i = static_cast<Eigen::Index>(ordinary_);
  const std::size_t given = found.size() - causes_.size();
  for (std::size_t c = 0; c < causes_.size(); ++c) {
    for (std::size_t k = 0; k < causes_[c].effect->parameters.size(); ++k) {
      if (!causes_[c].effect->parameters[k].fitted) continue;
      found[given + c].parameters[k].sd = posterior_.parameters().slope(i, z_[i]) * std::sqrt(covariance(i, i));
      ++i;
    }
  }
  found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(given));
  return found;
}

PoseFit fittedFrom(const PoseProblem& problem, std::span<const Pose> poses, const std::vector<ArmCause>& causes,
                   const Eigen::VectorXd& z) {
  PoseFit fit(problem, poses, causes);
  const Eigen::VectorXd start = fit.extended(z);
  fit.posterior().whiten(start);
  fit.descend(start);
  return fit;
}

std::vector<double> unseenDistances(const PoseFit& fit, const PoseProblem& problem, std::span<const Pose> poses,
                                    const PoseFit& whitening_from) {
  PoseFit like(problem, poses, whitening_from.causes());
  like.posterior().whiten(whitening_from.z());
  PoseFit there(problem, poses, fit.causes());
  there.posterior().whitenLike(like.posterior());
  std::vector<double> distances;
  for (const PoseResidual& pose : there.posterior().evaluate(fit.z(), false)) {
    distances.push_back(pose.valid ? pose.error.squaredNorm() : kNoEquilibrium);
  }
  return distances;
}

}  // namespace simgap
