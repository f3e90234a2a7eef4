#include "motion_candidates.h"

#include <algorithm>
#include <cmath>

#include "motion_heldout.h"
#include "simgap/measure/logs/stamps.h"

namespace simgap {
namespace {

constexpr double kKnownClocks = 0.005;  // [s] to which clocks agree where nothing is wrong with them
constexpr double kOfRow = 0.5;          // of the time between two, as a standard deviation: when a command changed
constexpr double kOwnClock = 2.0;       // of that, what a fit's own clock may carry: it would hide the cause

}  // namespace

MotionProblem motionProblem(const ArmModel& model, const MotionCalibrationConfig& config) {
  MotionProblem problem{model, config.parameters, config.motions, {}};
  double& delay = problem.options.capture_delay_sd;
  delay = std::min(delay, kKnownClocks);  // more is a cause: joint-clock-offset
  problem.options.capture_delay_farthest = kOwnClock;
  problem.options.coarse_changes = true;
  return problem;
}

double usualRow(std::span<const RecordedMotion> motions) {
  double row = 0.0;
  for (const RecordedMotion& motion : motions) row = std::max(row, usualStep(motion.times()));
  return row;
}

MotionCandidate candidateOf(const MotionCauseFit& fit, const char* role) {
  const Eigen::VectorXd& z = fit.here().z;
  MotionCandidate candidate{labelOf(fit.causes()),           role,        -fit.objective(),
                            fit.posterior().captureDelay(z), fit.model(), fit.covariance()};
  // What a cause's law leaves of it, the ordinary parameters have taken up as far as they can: they would be elsewhere
  // with a size that is off by as much. Without the cause they show it.
  const Eigen::MatrixXd known = candidate.covariance;
  Eigen::Index i = z.size() - 1;
  for (const ArmCause& cause : fit.causes()) i -= fittedParameters(*cause.effect);
  for (const ArmCause& cause : fit.causes()) {
    const double row = cause.effect->command_delay ? kOfRow * usualRow(fit.motions()) : 0.0;
    for (Eigen::Index k = 0; k < fittedParameters(*cause.effect); ++k, ++i) {
      const double of_law = cause.effect->law_sd * z[i];  // z = 0: the cause is not there
      const double size = std::hypot(of_law, row / fit.posterior().parameters().slope(i, z[i]));
      const Eigen::VectorXd with = known.col(i) / known(i, i) * size;
      candidate.covariance += with * with.transpose();
    }
  }
  return candidate;
}

void compareWithFirst(std::vector<MotionCandidate>& candidates, double variance) {
  const double first = candidates.front().log_odds;
  for (MotionCandidate& candidate : candidates) candidate.log_odds = (candidate.log_odds - first) / variance;
}

Eigen::ArrayXd logSquares(const Eigen::MatrixXd& squares) {
  Eigen::ArrayXd logs(squares.cols());
  for (Eigen::Index m = 0; m < squares.cols(); ++m) logs[m] = std::log(meanSquare(squares.col(m)));
  return logs;
}

MotionReference referenceOf(const Eigen::MatrixXd& fitted, const Eigen::MatrixXd& unseen) {
  MotionReference reference;
  reference.variance = std::max(1.0, meanSquare(unseen));
  std::vector<double> all;
  double sum = 0.0, count = 0.0;
  for (const double log : logSquares(unseen)) {
    if (!std::isfinite(log)) continue;
    all.push_back(log);
    sum += log;
    count += 1.0;
  }
  reference.mean = sum / std::max(1.0, count);
  for (const double log : logSquares(fitted)) {
    if (std::isfinite(log)) all.push_back(log);
  }
  reference.motions = static_cast<int>(all.size());
  double squares = 0.0;
  for (const double log : all) squares += std::pow(log - reference.mean, 2);
  reference.sd = std::sqrt(squares / std::max(1.0, static_cast<double>(all.size()) - 1.0));
  return reference;
}

}  // namespace simgap
