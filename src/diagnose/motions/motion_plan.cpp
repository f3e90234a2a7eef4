#include "motion_plan.h"

#include <algorithm>

namespace simgap {
namespace {

// What stages take, of diagnoses of the arm of eleven muscles and of forearms; `derivatives` are a rollout of every
// motion for each parameter.
constexpr double kPlainDerivatives = 3.8;  // at the prior's mean, then anew until nothing is gained
constexpr double kTriedOfAll = 12.0;       // of the hypotheses of single muscles, on all motions
constexpr double kScreenedOn = 4.0;        // motions that all of these are tried on
constexpr double kTriedAt = 2.0;           // where all others are tried
constexpr double kTriedAgain = 36.0;       // starts of those that look best
constexpr double kPerFit = 40.0;           // evaluations of a fit with the derivatives at hand, from two places
constexpr double kUsualFits = 6.0;
constexpr double kUsualDerivatives = 4.5;  // of the fits that may win
constexpr double kFurtherToo = 0.5;        // of what a further cause would take: often none is looked for
constexpr double kLongerThanUsual = 0.1;   // of a stage that has taken all that was expected: what may be left of it

}  // namespace

MotionPlan::MotionPlan(std::size_t parameters, std::size_t motions, std::size_t single, std::size_t other) {
  const auto per_motion = static_cast<double>(motions);
  const double derivatives = static_cast<double>(parameters) * per_motion, tried = static_cast<double>(single);
  usual_[kPlain] = kPlainDerivatives * derivatives;
  usual_[kScan] = std::min(kScreenedOn, per_motion) * tried +
                  per_motion * (std::min(kTriedOfAll, tried) + kTriedAt * static_cast<double>(other) + kTriedAgain);
  usual_[kFits] = kUsualFits * kPerFit * per_motion;
  usual_[kDerivatives] = kUsualDerivatives * derivatives;
  usual_[kFurther] = kFurtherToo * (0.5 * usual_[kScan] + usual_[kFits] + derivatives);
}

void MotionPlan::begin(Stage stage, long rollouts) {
  stage_ = stage;
  began_ = rollouts;
}

double MotionPlan::done(long rollouts) {
  const double usual = usual_[stage_], played = static_cast<double>(rollouts - began_);
  double left = std::max(usual - played, kLongerThanUsual * usual);
  for (std::size_t later = stage_ + 1; later < kStages; ++later) left += usual_[later];
  shown_ = std::max(shown_, static_cast<double>(rollouts) / (static_cast<double>(rollouts) + left));
  return shown_;
}

}  // namespace simgap
