#include "simgap/fit/poses/levenberg_marquardt.h"

#include <ceres/ceres.h>

#include <functional>
#include <limits>

#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Residuals = std::function<const std::vector<PoseResidual>&(const Eigen::VectorXd& z, bool jacobians)>;

/// All poses at once, before Ceres asks for them one by one.
class Sweep : public ceres::EvaluationCallback {
 public:
  Sweep(Eigen::VectorXd& z, Residuals residuals) : z_(z), residuals_(std::move(residuals)) {}
  /// With derivatives always: where a step is taken, Ceres asks for them at a point that it knows already, and finding
  /// the equilibria once more would cost as much as they do.
  void PrepareForEvaluation(bool, bool new_point) override {
    if (!new_point) return;
    current_ = &residuals_(z_, /*jacobians=*/true);
    poses_ += static_cast<long>(current_->size());
  }
  const PoseResidual& pose(std::size_t p) const { return (*current_)[p]; }
  long poses() const { return poses_; }

 private:
  Eigen::VectorXd& z_;  // Ceres writes each trial point here first
  Residuals residuals_;
  const std::vector<PoseResidual>* current_ = nullptr;
  long poses_ = 0;
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class PoseCost : public ceres::CostFunction {
 public:
  PoseCost(const Sweep& sweep, std::size_t pose, Eigen::Index residuals, Eigen::Index parameters)
      : sweep_(sweep), pose_(pose) {
    set_num_residuals(static_cast<int>(residuals));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const PoseResidual& pose = sweep_.pose(pose_);
    if (!pose.valid) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, pose.error.size()) = pose.error;
    if (jacobians && jacobians[0]) {
      Eigen::Map<RowMajor>(jacobians[0], pose.jacobian.rows(), pose.jacobian.cols()) = pose.jacobian;
    }
    return true;
  }

 private:
  const Sweep& sweep_;
  std::size_t pose_;
};

class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(const ScaledParameters& parameters) : weights_(parameters.size()) {
    for (Eigen::Index i = 0; i < weights_.size(); ++i) weights_[i] = parameters.hasPrior(i) ? 1.0 : 0.0;
    set_num_residuals(static_cast<int>(weights_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(weights_.size()));
  }
  bool Evaluate(double const* const* z, double* residuals, double** jacobians) const override {
    const Eigen::Index n = weights_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) = weights_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(z[0], n));
    if (jacobians && jacobians[0]) Eigen::Map<RowMajor>(jacobians[0], n, n) = weights_.asDiagonal().toDenseMatrix();
    return true;
  }

 private:
  Eigen::VectorXd weights_;
};

class StopWhenInterrupted : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return interruptRequested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
};

struct Descent {
  int iterations;
  long evaluations;
  bool usable;
};

Descent descend(const PosePosterior& posterior, Residuals residuals, Eigen::VectorXd& z, int max_iterations,
                double tolerance) {
  Sweep sweep(z, std::move(residuals));
  ceres::Problem::Options ownership;
  ownership.evaluation_callback = &sweep;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  ceres::CauchyLoss loss(kRobustScale);
  const int n = posterior.degreesOfFreedom();
  for (std::size_t p = 0; p < posterior.poses().size(); ++p) {
    problem.AddResidualBlock(new PoseCost(sweep, p, n, z.size()), &loss, z.data());
  }
  const ScaledParameters& parameters = posterior.parameters();
  problem.AddResidualBlock(new PriorCost(parameters), nullptr, z.data());
  for (int i = 0; i < z.size(); ++i) {
    if (std::isfinite(parameters.lower(i))) problem.SetParameterLowerBound(z.data(), i, parameters.lower(i));
    if (std::isfinite(parameters.upper(i))) problem.SetParameterUpperBound(z.data(), i, parameters.upper(i));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = 1e-8;
  options.num_threads = 1;  // the starts are parallel, and the sum must not depend on threads
  options.logging_type = ceres::SILENT;
  StopWhenInterrupted interruption;
  options.callbacks.push_back(&interruption);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const int steps = summary.iterations.empty() ? 0 : summary.iterations.back().iteration;
  return {steps, sweep.poses(), summary.IsSolutionUsable()};
}

}  // namespace

PosteriorFit descendPosterior(PosePosterior& posterior, const Eigen::VectorXd& z, int max_iterations,
                              double tolerance) {
  PosteriorFit fit;
  fit.z = z;
  const Descent descent = descend(
      posterior,
      [&](const Eigen::VectorXd& at, bool jacobians) -> const auto& { return posterior.evaluate(at, jacobians); },
      fit.z, max_iterations, tolerance);
  fit.iterations = descent.iterations;
  fit.evaluations = descent.evaluations;
  fit.objective = descent.usable ? posterior.objective(fit.z) : std::numeric_limits<double>::infinity();
  return fit;
}

Eigen::VectorXd balanceTorques(PosePosterior& posterior, const Eigen::VectorXd& z) {
  constexpr int kIterations = 5;
  constexpr double kBalanceTolerance = 1e-7;
  Eigen::VectorXd balanced = z;
  for (const double sd : {20.0, 10.0, 5.0, 2.5, 1.2, 0.6}) {
    posterior.whiten(balanced);
    descend(
        posterior,
        [&](const Eigen::VectorXd& at, bool) -> const auto& { return posterior.evaluateTorques(at, sd * kDegree); },
        balanced, kIterations, kBalanceTolerance);
  }
  return balanced;
}

}  // namespace simgap
