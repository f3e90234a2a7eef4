#include "stray_friction.h"

#include <cmath>

namespace simgap {
namespace {

constexpr double kShareStep = 1.4;  // of stray friction
constexpr double kSmallestShare = 0.1, kLargestShare = 4.0;

}  // namespace

PoseFit settledFit(PoseProblem& problem, std::span<const Pose> poses, const std::vector<ArmCause>& causes,
                   const Eigen::VectorXd& z) {
  const auto fitWith = [&](double share) {
    problem.stray_friction = share;
    return fittedFrom(problem, poses, causes, z);
  };
  const auto logPosterior = [](PoseFit& fit, double share) {
    return fit.logEvidence() - 0.5 * std::pow(std::log(share), 2);
  };
  double share = problem.stray_friction;
  PoseFit best = fitWith(share);
  double highest = logPosterior(best, share);
  const double half_step = std::sqrt(kShareStep);
  for (const double factor : {1.0 / kShareStep, kShareStep, 1.0 / half_step, half_step}) {
    bool better = true;
    for (double next = share * factor; better && next > kSmallestShare && next < kLargestShare; next *= factor) {
      PoseFit other = fitWith(next);
      const double value = logPosterior(other, next);
      better = value > highest;
      if (!better) break;
      highest = value;
      share = next;
      best = std::move(other);
    }
  }
  problem.stray_friction = share;
  return best;
}

}  // namespace simgap
