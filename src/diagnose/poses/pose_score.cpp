#include "pose_score.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

// Half of s^T M s at which a cause passes the selection for sure: its threshold, the price of some 80 hypotheses and
// two standard deviations of the score.
constexpr double kRevealed = 16.0;

constexpr double kJump = 3.0;  // [sd] of a whitened pose

Eigen::VectorXd stackErrors(const std::vector<PoseResidual>& poses) {
  const Eigen::Index n = poses.front().error.size();
  Eigen::VectorXd all(n * std::ssize(poses));
  for (Eigen::Index p = 0; p < std::ssize(poses); ++p) all.segment(p * n, n) = poses[p].error;
  return all;
}

/// The fit's causes and one more, on its poses with its whitening.
PoseFit extendedBy(const PoseProblem& problem, PoseFit& fit, const ArmCause& cause) {
  PoseFit more(problem, fit.posterior().poses(), withOneMore(fit.causes(), cause));
  more.posterior().whitenLike(fit.posterior());
  more.setSolution(more.extended(fit.z()));
  return more;
}

}  // namespace

PoseScore::PoseScore(PoseFit& fit) : fit_(fit) {
  const Eigen::LLT<Eigen::MatrixXd> factor(fit.curvature());
  const std::vector<PoseResidual>& poses = fit.linearised();
  const Eigen::Index n = poses.front().error.size();
  residual_.resize(n * std::ssize(poses));
  left_.resize(fit.z().size(), residual_.size());
  for (Eigen::Index p = 0; p < std::ssize(poses); ++p) {
    const PoseResidual& pose = poses[p];
    roots_.push_back(std::sqrt(robustWeight(pose.error.squaredNorm())));
    residual_.segment(p * n, n) = roots_.back() * pose.error;
    left_.middleCols(p * n, n) = roots_.back() * pose.jacobian.transpose();
  }
  factor.matrixL().solveInPlace(left_);
}

double PoseScore::information(const Eigen::VectorXd& s) const { return s.squaredNorm() - (left_ * s).squaredNorm(); }

Eigen::MatrixXd PoseScore::slopes(const PoseProblem& problem, const ArmCause& cause) const {
  PoseFit more = extendedBy(problem, fit_, cause);
  const std::vector<PoseResidual>& poses = more.linearised();
  const Eigen::Index first = fit_.z().size();
  const Eigen::Index fitted = more.z().size() - first;
  const Eigen::Index n = poses.front().error.size();
  Eigen::MatrixXd slopes(n * std::ssize(poses), fitted);
  for (Eigen::Index p = 0; p < std::ssize(poses); ++p) {
    const auto at = static_cast<std::size_t>(p);
    slopes.middleRows(p * n, n) = roots_[at] * poses[at].jacobian.rightCols(fitted);
  }
  for (Eigen::Index c = 0; c < fitted; ++c) {
    slopes.col(c) /= more.posterior().parameters().slope(first + c, more.z()[first + c]);
  }
  return slopes;
}

Eigen::VectorXd PoseScore::change(const PoseProblem& problem, const ArmCause& cause) const {
  const Eigen::VectorXd before = stackErrors(fit_.posterior().evaluate(fit_.z(), false));
  PoseFit more = extendedBy(problem, fit_, cause);
  const std::vector<PoseResidual>& poses = more.posterior().evaluate(more.z(), false);
  Eigen::VectorXd change = stackErrors(poses) - before;
  const Eigen::Index n = poses.front().error.size();
  for (Eigen::Index p = 0; p < std::ssize(poses); ++p) {
    // A pose that falls into another equilibrium, or has none, says nothing of what a little more would do.
    const auto at = static_cast<std::size_t>(p);
    const double part = std::min(1.0, kJump / std::max(kJump, change.segment(p * n, n).norm()));
    change.segment(p * n, n) *= poses[at].valid ? roots_[at] * part : 0.0;
  }
  return change;
}

void placeMoments(const PoseProblem& problem, PoseFit& fit, std::vector<ArmHypothesis>& hypotheses) {
  constexpr std::size_t kMoments = 2;  // per muscle; neighbours of the best hardly differ from it
  constexpr Eigen::Index kApart = 4;   // [poses]
  constexpr Eigen::Index kSide = 4;    // poses before a moment and behind it: one pose that is off is no slip
  const std::span<const Pose> poses = fit.posterior().poses();
  const Eigen::Index n = fit.posterior().degreesOfFreedom();
  std::vector<ArmHypothesis*> slips;
  for (ArmHypothesis& hypothesis : hypotheses) {
    if (hypothesis.effect->from_moment) slips.push_back(&hypothesis);
  }
  forEach(problem, slips.size(), [&](std::size_t h) {
    ArmHypothesis& slip = *slips[h];
    PoseFit own = fit;  // its posterior holds the state of an evaluation
    const PoseScore own_score(own);
    const EffectParameters always = {0.0, -1e300};
    Eigen::VectorXd s = own_score.slopes(problem, {slip.effect, slip.target, always}).col(0);
    struct Moment {
      Eigen::Index pose;
      double gain, angle;
    };
    std::vector<Moment> moments;
    for (Eigen::Index p = 1; p < std::ssize(poses); ++p) {
      s.segment((p - 1) * n, n).setZero();
      if (p < kSide || p + kSide > std::ssize(poses)) continue;
      const double information = own_score.information(s) + 1.0 / std::pow(slip.effect->parameters[0].scale, 2);
      const double slope = s.dot(own_score.residual());
      moments.push_back({p, 0.5 * slope * slope / information, -slope / information});
    }
    std::ranges::stable_sort(moments, std::greater<>(), &Moment::gain);
    slip.starts.clear();
    std::vector<Eigen::Index> taken;
    for (const Moment& moment : moments) {
      if (slip.starts.size() == kMoments) break;
      if (std::ranges::any_of(taken, [&](Eigen::Index p) { return std::abs(p - moment.pose) < kApart; })) continue;
      taken.push_back(moment.pose);
      const auto p = static_cast<std::size_t>(moment.pose);
      slip.starts.push_back({moment.angle, 0.5 * (poses[p - 1].time + poses[p].time)});
    }
  });
}

namespace {

/// Without contact a wrap has no slope: it grows until what it changes would be seen, and the last doubling is
/// interpolated as a power law.
double smallestWrap(const PoseProblem& problem, const PoseScore& score, ArmCause cause) {
  const ArmEffectParameter p = onArm(cause.effect->parameters[0], sizesOf(problem.nominal));
  double below = 0.0, below_gain = 0.0;
  for (double magnitude = 0.1 * p.scale; magnitude <= 3.0 * p.scale; magnitude *= 1.3) {
    cause.start[0] = magnitude;
    const double gain = 0.5 * score.information(score.change(problem, cause));
    if (gain >= kRevealed && below_gain > 0.0) {
      const double power = std::log(gain / below_gain) / std::log(magnitude / below);
      return below * std::pow(kRevealed / below_gain, 1.0 / power);
    }
    if (gain >= kRevealed) return magnitude;
    below = magnitude;
    below_gain = gain;
  }
  return std::nan("");
}

double smallestRevealed(const PoseProblem& problem, const PoseScore& score, const ArmHypothesis& hypothesis,
                        std::span<const Pose> poses) {
  ArmCause cause{hypothesis.effect, hypothesis.target, hypothesis.starts.front()};
  if (cause.effect->path) return smallestWrap(problem, score, cause);
  cause.start[0] = cause.effect->parameters[0].neutral;
  if (cause.effect->from_moment) cause.start[1] = poses[poses.size() / 2].time;
  const double information = score.information(score.slopes(problem, cause).col(0));
  return information > 0.0 ? std::sqrt(2.0 * kRevealed / information) : std::nan("");
}

}  // namespace

std::vector<Detectable> detectableMagnitudes(const PoseProblem& problem, PoseFit& fit,
                                             std::vector<ArmHypothesis> hypotheses) {
  std::erase_if(hypotheses, [&](const ArmHypothesis& h) {
    return std::ranges::any_of(fit.causes(), [&](const ArmCause& cause) { return h.isOf(cause); });
  });
  std::vector<Detectable> detectable(hypotheses.size());
  const auto magnitudeOf = [&](std::size_t h) {
    PoseFit own = fit;
    return smallestRevealed(problem, PoseScore(own), hypotheses[h], own.posterior().poses());
  };
  forEachOnRanks(problem, hypotheses.size(), fit.z(), magnitudeOf, [&](std::size_t h, double magnitude) {
    const ArmEffectParameter& p = hypotheses[h].effect->parameters[0];
    detectable[h] = {std::string(hypotheses[h].effect->name), hypotheses[h].target, std::string(p.name),
                     std::string(p.unit), magnitude};
  });
  std::erase_if(detectable, [](const Detectable& d) { return std::isnan(d.magnitude95); });
  return detectable;
}

}  // namespace simgap
