#include "simgap/fit/poses/pose_uncertainty.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "identifiability.h"
#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr double kTinyCurvature = 1e-9;  // in prior units: nothing bounds such a direction
constexpr std::size_t kCloud = 200;      // commands that stand for any pose of the arm
constexpr int kErrorDraws = 400;
constexpr std::uint32_t kCloudPurpose = 5, kDrawPurpose = 6;

Eigen::MatrixXd stackJacobians(const std::vector<PoseResidual>& poses, bool weighted) {
  Eigen::Index rows = 0;
  for (const PoseResidual& pose : poses) rows += pose.valid ? pose.error.size() : 0;
  Eigen::MatrixXd stacked(rows, poses.front().jacobian.cols());
  rows = 0;
  for (const PoseResidual& pose : poses) {
    if (!pose.valid) continue;
    const double weight = weighted ? std::sqrt(robustWeight(pose.error.squaredNorm())) : 1.0;
    stacked.middleRows(rows, pose.error.size()) = weight * pose.jacobian;
    rows += pose.error.size();
  }
  return stacked;
}

/// Of the negative log posterior; 0 for a parameter at its bound that would leave it.
Eigen::VectorXd posteriorGradient(const std::vector<PoseResidual>& poses, const ScaledParameters& scaled,
                                  const Eigen::VectorXd& z) {
  constexpr double kAtBound = 1e-6;  // [sd]
  Eigen::VectorXd gradient(z.size());
  for (Eigen::Index i = 0; i < z.size(); ++i) gradient[i] = scaled.hasPrior(i) ? z[i] : 0.0;
  for (const PoseResidual& pose : poses) {
    if (!pose.valid) continue;
    gradient += robustWeight(pose.error.squaredNorm()) * (pose.jacobian.transpose() * pose.error);
  }
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const bool leaves = (z[i] <= scaled.lower(i) + kAtBound && gradient[i] > 0.0) ||
                        (z[i] >= scaled.upper(i) - kAtBound && gradient[i] < 0.0);
    if (leaves) gradient[i] = 0.0;
  }
  return gradient;
}

/// How far the optimum still is [sd]: what is gained along the Newton step says it, where that promises more than there
/// is. Where a line is just slack the posterior has a kink, at which slopes do not vanish.
double stillToGo(PosePosterior& posterior, const Eigen::VectorXd& z, const Eigen::VectorXd& gradient,
                 const Eigen::MatrixXd& covariance) {
  constexpr int kHalvings = 10;
  const double promised = std::sqrt(gradient.dot(covariance * gradient));
  if (promised <= kAtOptimum) return promised;
  const double here = posterior.objective(z);
  if (!std::isfinite(here)) return promised;
  const Eigen::VectorXd step = covariance * gradient;
  double lowest = std::numeric_limits<double>::infinity(), part = 1.0;
  for (int i = 0; i < kHalvings; ++i, part *= 0.5) lowest = std::min(lowest, posterior.objective(z - part * step));
  posterior.objective(z);                       // which it holds again
  if (!std::isfinite(lowest)) return promised;  // no way that way, and nothing said of others
  return std::min(promised, std::sqrt(2.0 * std::max(0.0, here - lowest)));
}

/// Inverse of a curvature; directions that nothing bounds get the variance 1 / kTinyCurvature.
Eigen::MatrixXd invertCurvature(const Eigen::MatrixXd& curvature) {
  const SymmetricEigen eigen = symmetricEigen(curvature);
  const Eigen::VectorXd bounded = eigen.values.cwiseMax(kTinyCurvature);
  return eigen.vectors * bounded.cwiseInverse().asDiagonal() * eigen.vectors.transpose();
}

/// Of z, shape (parameters, parameters). \param jacobian  weighted, of all poses
Eigen::MatrixXd posteriorCovariance(const Eigen::MatrixXd& jacobian, const ScaledParameters& scaled) {
  Eigen::MatrixXd curvature = jacobian.transpose() * jacobian;
  for (Eigen::Index i = 0; i < scaled.size(); ++i) curvature(i, i) += scaled.hasPrior(i) ? 1.0 : 0.0;
  return invertCurvature(curvature);
}

}  // namespace

Verdict verdictOfShare(double of_prior) {
  constexpr double kUntouched = 0.95;
  if (of_prior <= kHalvedPrior) return Verdict::kIdentifiable;
  return of_prior > kUntouched ? Verdict::kNotIdentifiable : Verdict::kWeak;
}

std::string_view toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kIdentifiable:
      return "identifiable";
    case Verdict::kWeak:
      return "weak";
    case Verdict::kNotIdentifiable:
      break;
  }
  return "not identifiable";
}

PoseUncertainty assessUncertainty(PosePosterior& posterior, const Eigen::VectorXd& z, const ParameterSpace& space) {
  const ScaledParameters& scaled = posterior.parameters();
  const std::vector<PoseResidual> residuals = posterior.evaluate(z, true);
  PoseUncertainty result;
  for (const PoseResidual& residual : residuals) {
    result.distances.push_back(residual.valid ? residual.error.norm() : std::numeric_limits<double>::quiet_NaN());
  }
  if (std::none_of(residuals.begin(), residuals.end(), [](const PoseResidual& r) { return r.valid; })) {
    throw NumericsError("uncertainty: no pose has a stable equilibrium with these parameters");
  }
  const Eigen::MatrixXd jacobian = stackJacobians(residuals, true);
  result.covariance = posteriorCovariance(jacobian, scaled);
  const Eigen::VectorXd gradient = posteriorGradient(residuals, scaled, z);
  result.from_optimum = stillToGo(posterior, z, gradient, result.covariance);
  const Eigen::VectorXd singular = singularValues(jacobian);
  result.singular_values.assign(singular.begin(), singular.end());

  // What no pose could tell, from a cloud of commands; whitening does not matter for that.
  const std::vector<Pose> cloud = drawCommands(posterior, z, kCloud, 0);
  Eigen::MatrixXd anywhere = jacobian;
  if (!cloud.empty()) {
    PosePosterior elsewhere(posterior, cloud);
    elsewhere.whiten(z);
    const Eigen::MatrixXd there = stackJacobians(elsewhere.evaluate(z, true), false);
    anywhere.conservativeResize(jacobian.rows() + there.rows(), Eigen::NoChange);
    anywhere.bottomRows(there.rows()) = there;
  }
  Eigen::VectorXd unknowable;  // variance that is left however many poses there are, of the prior's
  result.combinations = findCombinations(jacobian, anywhere, space, unknowable);

  for (Eigen::Index i = 0; i < z.size(); ++i) {
    const double slope = scaled.slope(i, z[i]);
    const double sd_z = std::sqrt(result.covariance(i, i));
    const bool bounded = scaled.hasPrior(i) || sd_z < 0.1 / std::sqrt(kTinyCurvature);
    ParameterUncertainty parameter{scaled.hasPrior(i) ? slope : std::numeric_limits<double>::infinity(),
                                   bounded ? slope * sd_z : std::numeric_limits<double>::infinity(),
                                   verdictOfShare(scaled.hasPrior(i) ? sd_z : 0.0)};
    if (!bounded || std::sqrt(unknowable[i]) > kHalvedPrior) parameter.verdict = Verdict::kNotIdentifiable;
    result.parameters.push_back(parameter);
  }
  return result;
}

PredictedError predictError(const PosePosterior& posterior, const Eigen::VectorXd& z,
                            const PoseUncertainty& uncertainty, std::span<const Pose> poses) {
  PosePosterior there(posterior, poses);
  there.whiten(z);
  const std::vector<PoseResidual> residuals = there.evaluate(z, true);  // whitened: noise and friction are N(0, 1)
  if (std::ranges::none_of(residuals, &PoseResidual::valid)) return {};
  const Eigen::MatrixXd spread = uncertainty.covariance.llt().matrixL();
  const std::vector<Joint>& joints = posterior.model().joints;
  std::vector<std::vector<double>> mje(joints.size(), std::vector<double>(kErrorDraws, 0.0));
  std::vector<Eigen::MatrixXd> unwhiten;
  for (std::size_t p = 0; p < poses.size(); ++p) unwhiten.push_back(inverse(there.whitening(p)));
  const CounterRandom random(0);
  for (std::uint32_t draw = 0; draw < kErrorDraws; ++draw) {
    const auto normal = [&](std::size_t place, Eigen::Index i) {
      return random.normalPair(
          {draw, static_cast<std::uint32_t>(place), static_cast<std::uint32_t>(i), kDrawPurpose})[0];
    };
    Eigen::VectorXd change(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) change[i] = normal(0, i);
    change = spread * change;
    int valid = 0;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      if (!residuals[p].valid) continue;
      ++valid;
      Eigen::VectorXd error = residuals[p].jacobian * change;
      for (Eigen::Index i = 0; i < error.size(); ++i) error[i] += normal(p + 1, i);
      error = unwhiten[p] * error;
      Eigen::Index d = 0;
      for (std::size_t j = 0; j < joints.size(); ++j) {
        const int components = joints[j].degreesOfFreedom();
        mje[j][draw] += error.segment(d, components).norm();
        d += components;
      }
    }
    for (auto& of_joint : mje) of_joint[draw] /= valid;
  }
  PredictedError predicted;
  for (std::vector<double>& of_joint : mje) {
    std::sort(of_joint.begin(), of_joint.end());
    double sum = 0.0;
    for (const double error : of_joint) sum += error;
    predicted.mean.push_back(sum / kErrorDraws);
    predicted.lower.push_back(of_joint[kErrorDraws / 20]);
    predicted.upper.push_back(of_joint[kErrorDraws - 1 - kErrorDraws / 20]);
  }
  return predicted;
}

namespace {

/// Stable, no cord beyond its linear range, and no line pulled harder.
bool feasible(EquilibriumArm& arm, std::span<const double> shafts, double most_tension) {
  if (!arm.solve(shafts).stable) return false;
  const std::vector<Muscle>& muscles = arm.energy().model().muscles;
  for (std::size_t m = 0; m < muscles.size(); ++m) {
    if (arm.energy().expansion(m) > ShockCord::kLinearRange * muscles[m].shock_cord.rest_length) return false;
    if (arm.energy().tension(m) > most_tension) return false;
  }
  return true;
}

/// Draws a command: anywhere within the ranges; where muscles would fight too hard, nearer to one that the arm has
/// seen.
struct CommandDraw {
  std::span<const Pose> recorded;
  std::vector<double> lower, upper;  ///< of the recorded shafts, shape (muscles) [rad]
  CounterRandom random;
  double most_tension;  ///< [N]

  CommandDraw(std::span<const Pose> poses, std::uint64_t seed, double tension)
      : recorded(poses), lower(poses.front().shafts), upper(lower), random(seed), most_tension(tension) {
    for (const Pose& pose : recorded) {
      for (std::size_t m = 0; m < lower.size(); ++m) {
        lower[m] = std::min(lower[m], pose.shafts[m]);
        upper[m] = std::max(upper[m], pose.shafts[m]);
      }
    }
  }

  /// Empty where no equilibrium is found.
  std::optional<Pose> operator()(EquilibriumArm& arm, std::uint32_t attempt) const {
    const auto draw = [&](std::uint32_t place) { return random.uniform({attempt, place, 0, kCloudPurpose}); };
    const auto near = static_cast<std::size_t>(draw(0) * static_cast<double>(recorded.size()));
    const std::vector<double>& home = recorded[near].shafts;
    Pose command;
    command.name = fmt::format("c{:04d}", attempt);
    command.shafts.resize(home.size());
    for (const double way : {1.0, 0.75, 0.5, 0.25}) {
      for (std::uint32_t m = 0; m < home.size(); ++m) {
        const double anywhere = lower[m] + draw(1 + m) * (upper[m] - lower[m]);
        command.shafts[m] = home[m] + way * (anywhere - home[m]);
      }
      if (!feasible(arm, command.shafts, most_tension)) continue;
      command.joints = arm.joints();
      command.spread.assign(command.joints.size(), 0.0);
      return command;
    }
    return std::nullopt;
  }
};

}  // namespace

std::vector<Pose> drawCommands(const PosePosterior& posterior, const Eigen::VectorXd& z, std::size_t count,
                               std::uint64_t seed, double most_tension) {
  constexpr std::size_t kTriesPerPose = 20;
  constexpr std::size_t kAtOnce = 32;  // attempts; the last of them may be one too many
  const CommandDraw draw(posterior.poses(), seed, most_tension);
  tbb::enumerable_thread_specific<EquilibriumArm> arms(posterior.modelAt(z));
  std::vector<Pose> commands;
  for (std::size_t first = 0; commands.size() < count && first < kTriesPerPose * count; first += kAtOnce) {
    stopIfInterrupted();
    std::vector<std::optional<Pose>> drawn(std::min(kAtOnce, kTriesPerPose * count - first));
    tbb::parallel_for(std::size_t{0}, drawn.size(),
                      [&](std::size_t i) { drawn[i] = draw(arms.local(), static_cast<std::uint32_t>(first + i)); });
    for (std::optional<Pose>& command : drawn) {
      if (command && commands.size() < count) commands.push_back(std::move(*command));
    }
  }
  return commands;
}

}  // namespace simgap
