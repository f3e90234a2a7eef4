#include "motion_heldout.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnose/paired_error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr std::uint32_t kDrawsOfKnown = 16;
constexpr double kLargeRest = 1.5 * 1.5;   // mean square that no model of noise leaves
constexpr double kMissed = 1.25;           // mean square of a motion in which something is missing: noise makes it 1
constexpr double kKept = 0.05;             // of the mean square, by a model that explains a motion
constexpr Eigen::Index kFewestSaying = 3;  // motions
constexpr double kLost = 3.0;              // log gain of a motion that only one of two models can play

double errorOfMean(const Eigen::ArrayXd& values) {
  const auto count = static_cast<double>(values.size());
  return std::sqrt((values - values.mean()).square().sum() / (count - 1.0) / count);
}

/// Their mean with a 95 % interval by Student's t.
Interval meanOf(const Eigen::ArrayXd& values) {
  const double mean = values.mean();
  const double half = studentQuantile(static_cast<double>(values.size()) - 1.0) * errorOfMean(values);
  return {mean, mean - half, mean + half};
}

}  // namespace

MotionSplit splitMotions(const MotionSet& motions, const MotionSet* held_out, double fraction) {
  MotionSplit split{{motions.file, {}}, {motions.file, {}}};
  if (held_out) return {motions, *held_out};
  double owed = 0.5;  // spread evenly over the order of the set
  for (const RecordedMotion& motion : motions.motions) {
    owed += fraction;
    const bool judges = owed >= 1.0 - 1e-12;
    if (judges) owed -= 1.0;
    (judges ? split.judging : split.selecting).motions.push_back(motion);
  }
  return split;
}

namespace {

/// Means over each group's numbers, shape (joints, shafts and currents; motions); NaN where a motion has none.
/// \param squares  summed over the numbers of a block of a motion
template <class Squares>
Eigen::MatrixXd groupMeans(const MotionPosterior& posterior, const Squares& squares) {
  const auto joints = std::ssize(posterior.model().joints);
  const auto motions = std::ssize(posterior.motions());
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(joints + 2, motions), counts = sums;
  for (Eigen::Index m = 0; m < motions; ++m) {
    for (const ResidualBlock& block : posterior.motions()[static_cast<std::size_t>(m)].blocks()) {
      const Eigen::Index group = block.group == ChannelGroup::kJoint   ? static_cast<Eigen::Index>(block.item)
                                 : block.group == ChannelGroup::kShaft ? joints
                                                                       : joints + 1;
      sums(group, m) += squares(static_cast<std::size_t>(m), block);
      counts(group, m) += static_cast<double>(block.size);
    }
  }
  return sums.cwiseQuotient(counts);  // 0 / 0: NaN
}

}  // namespace

Eigen::MatrixXd groupSquares(const MotionPosterior& posterior, const MotionEvaluation& at) {
  return groupMeans(posterior, [&at](std::size_t motion, const ResidualBlock& block) {
    if (!at.valid || at.residuals[motion].size() == 0) return std::nan("");  // it could not be played
    return at.residuals[motion].segment(block.first, block.size).squaredNorm();
  });
}

Eigen::MatrixXd noiseSquares(const MotionPosterior& posterior) {
  return groupMeans(posterior, [](std::size_t, const ResidualBlock& block) {
    return static_cast<double>(block.size) * block.noise_share;
  });
}

Eigen::MatrixXd unseenSquares(const MotionCauseFit& fit, const Eigen::VectorXd& z, const MotionProblem& problem,
                              std::span<const RecordedMotion> motions) {
  const std::unique_ptr<MotionPosterior> unseen = posteriorWith(problem, fit.causes(), motions);
  const MotionEvaluation at = unseen->evaluate(z);
  stopIfInterrupted();
  return groupSquares(*unseen, at);
}

Eigen::VectorXd unknownSquares(const MotionCauseFit& fit, const MotionProblem& problem,
                               std::span<const RecordedMotion> motions) {
  const std::unique_ptr<MotionPosterior> unseen = posteriorWith(problem, fit.causes(), motions);
  const MotionEvaluation found = unseen->evaluate(fit.here().z);
  Eigen::VectorXd most = Eigen::VectorXd::Zero(std::ssize(unseen->model().joints) + 2);
  for (const Eigen::VectorXd& z : unseen->draws(fit.here().z, fit.covariance(), kDrawsOfKnown)) {
    MotionEvaluation moved = unseen->evaluate(z);
    stopIfInterrupted();
    if (!found.valid || !moved.valid) continue;
    for (std::size_t m = 0; m < motions.size(); ++m) moved.residuals[m] -= found.residuals[m];
    const Eigen::MatrixXd squares = groupSquares(*unseen, moved);
    for (Eigen::Index g = 0; g < most.size(); ++g) {
      if (squares.row(g).array().isFinite().any()) most[g] = std::max(most[g], meanSquare(squares.row(g)));
    }
  }
  return most;
}

bool isLeft(double missed, double fitted, double unknown) {
  return missed > kLargeRest + (fitted > kLargeRest ? 0.0 : unknown);
}

Eigen::ArrayXd logGains(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after) {
  std::vector<Eigen::Index> saying;
  for (Eigen::Index m = 0; m < before.cols(); ++m) {
    const double was = meanSquare(before.col(m)), is = meanSquare(after.col(m));
    if (!(was < kMissed && is < kMissed)) saying.push_back(m);
  }
  if (std::ssize(saying) >= kFewestSaying && std::ssize(saying) < before.cols()) {
    return logGains(before(Eigen::all, saying), after(Eigen::all, saying));
  }
  Eigen::ArrayXd gains(before.cols());
  for (Eigen::Index m = 0; m < before.cols(); ++m) {
    double sum = 0.0, groups = 0.0;
    for (Eigen::Index g = 0; g < before.rows(); ++g) {
      const bool was = std::isfinite(before(g, m)), is = std::isfinite(after(g, m));
      if (!was && !is) continue;
      sum += was && is ? std::log(before(g, m) / after(g, m)) : is ? kLost : -kLost;
      groups += 1.0;
    }
    gains[m] = groups > 0.0 ? sum / groups : 0.0;
  }
  return gains;
}

Interval gainOf(const Eigen::ArrayXd& log_gains) {
  const Interval mean = meanOf(log_gains);
  return {-std::expm1(-mean.value), -std::expm1(-mean.lower95), -std::expm1(-mean.upper95)};
}

Interval heldOutGain(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after) {
  const Eigen::ArrayXd log_gains = logGains(before, after);
  const Interval gain = gainOf(log_gains);
  bool reached = meanSquare(before) > kLargeRest && log_gains.minCoeff() > 0.0;
  for (Eigen::Index m = 0; m < after.cols(); ++m) {
    reached = reached && meanSquare(after.col(m)) < std::max(kMissed, kKept * meanSquare(before.col(m)));
  }
  if (gain.lower95 > 0.0 || !reached) return gain;
  const Interval odds = meanOf(log_gains.unaryExpr([](double g) { return logOdds(-std::expm1(-g)); }));
  return {gain.value, std::min(gain.value, inverseLogOdds(odds.lower95)),
          std::max(gain.value, inverseLogOdds(odds.upper95))};
}

double chanceOfGain(const Eigen::ArrayXd& log_gains) {
  const double error = errorOfMean(log_gains);
  if (error == 0.0) return log_gains.mean() > 0.0 ? 0.0 : 1.0;
  return studentTail(log_gains.mean() / error, static_cast<double>(log_gains.size()) - 1.0);
}

double explainedShare(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after, const Eigen::ArrayXd& floor) {
  std::vector<double> shares;
  for (Eigen::Index m = 0; m < before.cols(); ++m) {
    const double was = meanSquare(before.col(m)), is = meanSquare(after.col(m));
    if (!std::isfinite(was) && !std::isfinite(is)) continue;
    if (was <= floor[m]) continue;  // nothing was missing
    const double gap = was - std::min(floor[m], is);
    shares.push_back(!std::isfinite(was) ? 1.0 : !std::isfinite(is) ? 0.0 : (was - is) / gap);
  }
  return shares.empty() ? 0.0 : median(std::move(shares));
}

double meanSquare(const Eigen::MatrixXd& squares) {
  double sum = 0.0, count = 0.0;
  for (const double value : squares.reshaped()) {
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  return sum / count;
}

}  // namespace simgap
