#include "simgap/fit/motions/motion_posterior.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

constexpr std::uint32_t kDrawnParameters = 8;  // purpose of random numbers
constexpr double kFarthest = 6.0;  // prior sd: an effect that the model lacks drives parameters to nonsense otherwise

/// Where ranks differ in it they have come apart.
Bytes digestOf(std::span<const Eigen::VectorXd> z) {
  Bytes digest;
  for (const Eigen::VectorXd& one : z) pack(digest, one);
  return digest;
}

}  // namespace

/// What each thread plays motions with.
struct MotionPosterior::Workers {
  struct Worker {
    std::optional<MotionPlayer> player, coarse;
    PlayedMotion played;
    ArmModel model;
  };
  tbb::enumerable_thread_specific<Worker> own;
};

MotionPosterior::MotionPosterior(const ArmModel& model, std::span<const RecordedMotion> motions,
                                 std::span<const Pose> poses, const std::vector<ParameterSpace::Choice>& parameters,
                                 const PoseNoise& pose_noise, const Options& options)
    : model_(model),
      space_(model, parameters),
      scaled_(space_),
      options_(options),
      noise_(estimateNoise(motions, model.poseLayout(), options.noise)),
      workers_(std::make_shared<Workers>()) {
  const PoseLayout layout = model.poseLayout();
  for (const RecordedMotion& motion : motions) {
    motions_.emplace_back(motion, layout, noise_, options.discrepancy);
    playable_.emplace_back(motion, model.joints);
  }
  setHorizon(1.0);
  if (poses.empty()) return;
  std::vector<ParameterSpace::Choice> apart = parameters;
  for (ParameterSpace::Choice& choice : apart) choice.together = false;
  poses_.emplace(model, poses, ParameterSpace(model, apart), pose_noise);
  owners_ = space_.owners();
}

double MotionPosterior::lower(Eigen::Index i) const {
  if (i == scaled_.size()) return -options_.capture_delay_farthest;
  return std::max(scaled_.lower(i), scaled_.hasPrior(i) ? -kFarthest : -kInfinity);
}

double MotionPosterior::upper(Eigen::Index i) const {
  if (i == scaled_.size()) return options_.capture_delay_farthest;
  return std::min(scaled_.upper(i), scaled_.hasPrior(i) ? kFarthest : kInfinity);
}

void MotionPosterior::setHorizon(double share) {
  until_.clear();
  for (const MotionResiduals& motion : motions_) until_.push_back(motion.timeAt(share));
}

ArmModel MotionPosterior::modelAt(const Eigen::VectorXd& z) const {
  ArmModel model = model_;
  space_.apply(scaled_.values(z.head(scaled_.size())), model);
  return model;
}

/// With the calling thread's player.
void MotionPosterior::playOne(const ArmModel& model, double delay, std::size_t motion, bool coarse,
                              PlayedMotion& played) const {
  Workers::Worker& worker = workers_->own.local();
  std::optional<MotionPlayer>& player = coarse ? worker.coarse : worker.player;
  if (player) {
    player->setModel(model);
  } else {
    player.emplace(model, coarse ? options_.motion.coarser() : options_.motion);
  }
  player->play(playable_[motion], delay, played, until_[motion] + MotionResiduals::kWindow);
}

/// Of one motion, played by the calling thread's player, shape (residuals); empty where it could not be played, or
/// after an interrupt.
Eigen::VectorXd MotionPosterior::residualsOf(const ArmModel& model, double delay, std::size_t motion,
                                             bool coarse) const {
  Eigen::VectorXd residuals;
  if (interruptRequested()) return residuals;
  PlayedMotion& played = workers_->own.local().played;
  playOne(model, delay, motion, coarse, played);
  if (!played.valid) return residuals;
  residuals.resize(motions_[motion].size());
  motions_[motion].evaluate(played, residuals);
  return residuals;
}

std::vector<PoseResidual> MotionPosterior::evaluatePoses(const Eigen::VectorXd& z, bool jacobians) const {
  if (!poses_) return {};
  Eigen::VectorXd apart(std::ssize(owners_));
  for (std::size_t i = 0; i < owners_.size(); ++i) {
    apart[i] = z[owners_[i]];
  }
  std::vector<PoseResidual> poses = poses_->evaluate(apart, jacobians);
  for (PoseResidual& pose : poses) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(pose.jacobian.rows(), scaled_.size());
    for (std::size_t i = 0; i < owners_.size(); ++i) {
      jacobian.col(owners_[i]) += pose.jacobian.col(i);
    }
    pose.jacobian = std::move(jacobian);
  }
  return poses;
}

MotionEvaluation MotionPosterior::evaluate(const Eigen::VectorXd& z) const {
  MotionEvaluation evaluation;
  const ArmModel model = modelAt(z);
  evaluation.residuals.resize(motions_.size());
  computeOnRanks(
      std::span(evaluation.residuals), [&](std::size_t m) { return residualsOf(model, captureDelay(z), m); },
      /*one_by_one=*/false, digestOf({&z, 1}));
  evaluation.valid = true;
  for (std::size_t m = 0; m < motions_.size(); ++m) {
    if (evaluation.residuals[m].size() > 0) continue;
    evaluation.valid = false;
    evaluation.residuals[m] = Eigen::VectorXd::Zero(motions_[m].size());
  }
  evaluation.poses = evaluatePoses(z, false);
  evaluation.valid = evaluation.valid && std::ranges::all_of(evaluation.poses, &PoseResidual::valid);
  evaluation.objective = objectiveOf(evaluation, z);
  return evaluation;
}

std::vector<double> MotionPosterior::objectives(std::span<const Eigen::VectorXd> z,
                                                std::span<const std::size_t> some) const {
  const std::size_t motions = some.empty() ? motions_.size() : some.size();
  std::vector<double> losses(z.size() * motions, kInfinity), objectives(z.size());
  std::vector<ArmModel> models;
  for (const Eigen::VectorXd& one : z) models.push_back(modelAt(one));
  const auto lossAt = [&](std::size_t task) {
    const std::size_t k = task / motions, m = some.empty() ? task % motions : some[task % motions];
    const Eigen::VectorXd residuals = residualsOf(models[k], captureDelay(z[k]), m);
    if (residuals.size() == 0) return kInfinity;
    return lossOf(m, residuals);
  };
  computeOnRanks(std::span(losses), lossAt, /*one_by_one=*/false, digestOf(z));
  for (std::size_t k = 0; k < z.size(); ++k) {
    double sum = 0.0;
    for (std::size_t m = 0; m < motions; ++m) sum += losses[k * motions + m];
    for (Eigen::Index i = 0; i < z[k].size(); ++i) sum += hasPrior(i) ? z[k][i] * z[k][i] : 0.0;
    for (const PoseResidual& pose : evaluatePoses(z[k], false)) {
      sum += pose.valid ? robustLoss(pose.error.squaredNorm()) : kInfinity;
    }
    objectives[k] = 0.5 * sum;
  }
  return objectives;
}

std::vector<std::vector<Eigen::VectorXd>> MotionPosterior::residualsOf(std::span<const ArmModel> models,
                                                                       std::span<const double> delays,
                                                                       std::span<const std::size_t> some) const {
  const std::size_t motions = some.empty() ? motions_.size() : some.size();
  const auto motionOf = [&](std::size_t task) { return some.empty() ? task % motions : some[task % motions]; };
  std::vector<Eigen::VectorXd> flat(models.size() * motions);
  computeOnRanks(
      std::span(flat),
      [&](std::size_t task) { return residualsOf(models[task / motions], delays[task / motions], motionOf(task)); },
      /*one_by_one=*/false);
  std::vector<std::vector<Eigen::VectorXd>> residuals(models.size(), std::vector<Eigen::VectorXd>(motions_.size()));
  for (std::size_t task = 0; task < flat.size(); ++task) {
    residuals[task / motions][motionOf(task)] = std::move(flat[task]);
  }
  return residuals;
}

double MotionPosterior::lossOf(std::size_t motion, const Eigen::VectorXd& residuals) const {
  const double narrower = std::pow(kRobustScale / robust_scale_, 2);
  double loss = 0.0;
  for (const ResidualBlock& block : motions_[motion].blocks()) {
    if (!counts(motion, block)) continue;
    loss += robustLoss(narrower * residuals.segment(block.first, block.size).squaredNorm());
  }
  return motions_[motion].motion().weight * loss / narrower;
}

double MotionPosterior::objectiveOf(const MotionEvaluation& evaluation, const Eigen::VectorXd& z) const {
  if (!evaluation.valid) return kInfinity;
  double sum = 0.0;
  for (std::size_t m = 0; m < motions_.size(); ++m) sum += lossOf(m, evaluation.residuals[m]);
  for (const PoseResidual& pose : evaluation.poses) sum += robustLoss(pose.error.squaredNorm());
  for (Eigen::Index i = 0; i < z.size(); ++i) sum += hasPrior(i) ? z[i] * z[i] : 0.0;
  return 0.5 * sum;
}

std::vector<RowMajorF> MotionPosterior::changes(const Eigen::VectorXd& z, const Eigen::MatrixXd& moves,
                                                const MotionEvaluation& at,
                                                const std::function<void(std::size_t)>& progress) const {
  std::vector<RowMajorF> changes;
  for (const MotionResiduals& motion : motions_) {
    changes.emplace_back(RowMajorF::Constant(motion.size(), moves.cols(), std::numeric_limits<float>::quiet_NaN()));
  }
  std::vector<Eigen::VectorXd> from = at.residuals;
  if (options_.coarse_changes) {
    const ArmModel model = modelAt(z);
    computeOnRanks(
        std::span(from), [&](std::size_t m) { return residualsOf(model, captureDelay(z), m, true); },
        /*one_by_one=*/false, digestOf({&z, 1}));
  }
  std::atomic<std::size_t> done{0};
  const auto columnOf = [&](std::size_t task) {
    const std::size_t m = task % motions_.size();
    const Eigen::VectorXd moved = z + moves.col(static_cast<Eigen::Index>(task / motions_.size()));
    ArmModel& model = workers_->own.local().model;
    model = modelAt(moved);
    const Eigen::VectorXd residuals = residualsOf(model, captureDelay(moved), m, options_.coarse_changes);
    ++done;
    std::vector<float> column;
    if (residuals.size() == 0 || from[m].size() == 0) return column;
    const Eigen::VectorXf change = (residuals - from[m]).cast<float>();
    column.assign(change.begin(), change.end());
    if (progress && tbb::this_task_arena::current_thread_index() == 0) progress(done);
    return column;
  };
  const auto place = [&](std::size_t task, const std::vector<float>& column) {
    if (column.empty()) return;
    changes[task % motions_.size()].col(static_cast<Eigen::Index>(task / motions_.size())) =
        Eigen::Map<const Eigen::VectorXf>(column.data(), std::ssize(column));
  };
  shareOnRanks(static_cast<std::size_t>(moves.cols()) * motions_.size(), columnOf, place, /*one_by_one=*/false,
               digestOf({&z, 1}));
  return changes;
}

std::vector<RowMajorF> MotionPosterior::jacobian(const Eigen::VectorXd& z, const Eigen::VectorXd& steps,
                                                 MotionEvaluation& at,
                                                 const std::function<void(std::size_t)>& progress) const {
  Eigen::VectorXd inside = steps;  // the other way round where this one would leave the bounds
  std::vector<Eigen::Index> asked;
  for (Eigen::Index i = 0; i < size(); ++i) {
    if (z[i] + steps[i] > upper(i) || z[i] + steps[i] < lower(i)) inside[i] = -steps[i];
    if (steps[i] != 0.0) asked.push_back(i);
  }
  const Eigen::MatrixXd moves = inside.asDiagonal();
  std::vector<RowMajorF> jacobians;
  for (const RowMajorF& change : changes(z, moves(Eigen::all, asked), at, progress)) {
    RowMajorF& jacobian = jacobians.emplace_back(RowMajorF::Zero(change.rows(), size()));
    for (std::size_t k = 0; k < asked.size(); ++k) {
      // Where the first number is none, none of its column is: nothing is known of that parameter in that motion.
      const auto column = change.col(static_cast<Eigen::Index>(k));
      if (column.size() == 0 || std::isnan(column[0])) continue;
      jacobian.col(asked[k]) = column * (1.0F / static_cast<float>(inside[asked[k]]));
    }
  }
  at.poses = evaluatePoses(z, true);
  return jacobians;
}

std::vector<Eigen::VectorXd> MotionPosterior::draws(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                                                    std::uint32_t count) const {
  const CounterRandom random(0);
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  std::vector<Eigen::VectorXd> draws;
  for (std::uint32_t draw = 0; draw < count; ++draw) {
    Eigen::VectorXd normal(mean.size());
    for (Eigen::Index i = 0; i < normal.size(); ++i) {
      normal[i] = random.normalPair({draw, static_cast<std::uint32_t>(i), 0, kDrawnParameters})[0];
    }
    Eigen::VectorXd z = mean + root * normal;
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = std::clamp(z[i], lower(i), upper(i));
    draws.push_back(std::move(z));
  }
  return draws;
}

Eigen::VectorXd MotionPosterior::weights(std::size_t motion, const Eigen::VectorXd& residuals) const {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(residuals.size());
  const double narrower = std::pow(kRobustScale / robust_scale_, 2);
  for (const ResidualBlock& block : motions_[motion].blocks()) {
    if (!counts(motion, block)) continue;
    const double weight = robustWeight(narrower * residuals.segment(block.first, block.size).squaredNorm());
    weights.segment(block.first, block.size).setConstant(motions_[motion].motion().weight * weight);
  }
  return weights;
}

MotionPosterior::NormalEquations MotionPosterior::normalEquations(const Eigen::VectorXd& z, const MotionEvaluation& at,
                                                                  std::span<const RowMajorF> jacobians) const {
  const Eigen::Index n = size();
  NormalEquations normal{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  for (std::size_t m = 0; m < motions_.size(); ++m) {
    if (jacobians[m].rows() == 0) continue;
    const Eigen::VectorXd root = weights(m, at.residuals[m]).cwiseSqrt();
    constexpr Eigen::Index kRows = 512;  // at a time: in double precision
    for (Eigen::Index row = 0; row < root.size(); row += kRows) {
      const Eigen::Index rows = std::min(kRows, root.size() - row);
      const auto w = root.segment(row, rows);
      const Eigen::MatrixXd weighted = w.asDiagonal() * jacobians[m].middleRows(row, rows).cast<double>();
      normal.curvature.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
      normal.gradient += weighted.transpose() * w.cwiseProduct(at.residuals[m].segment(row, rows));
    }
  }
  for (const PoseResidual& pose : at.poses) {
    const double weight = robustWeight(pose.error.squaredNorm());
    normal.curvature.topLeftCorner(n - 1, n - 1)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(pose.jacobian.transpose(), weight);
    normal.gradient.head(n - 1) += weight * pose.jacobian.transpose() * pose.error;
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!hasPrior(i)) continue;
    normal.curvature(i, i) += 1.0;
    normal.gradient[i] += z[i];
  }
  normal.curvature.triangularView<Eigen::StrictlyUpper>() = normal.curvature.transpose();
  return normal;
}

}  // namespace simgap
