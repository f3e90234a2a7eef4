// What a bar says of a diagnosis that takes what diagnoses took.
#include "diagnose/motions/motion_plan.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace simgap {
namespace {

// Rollouts of stages of the eleven-muscle arm with friction of guides hidden, ten motions, 132 parameters.
constexpr std::array<std::pair<MotionPlan::Stage, long>, 4> kPlayed = {{{MotionPlan::kPlain, 4970},
                                                                        {MotionPlan::kScan, 1616},
                                                                        {MotionPlan::kFits, 2388},
                                                                        {MotionPlan::kDerivatives, 6534}}};

TEST(MotionPlan, ABarGoesByRollouts) {
  MotionPlan plan(132, 10, 99, 34);
  long played = 0;
  double all = plan.usual(MotionPlan::kFurther);  // another cause may be looked for
  for (const auto& [stage, rollouts] : kPlayed) all += static_cast<double>(rollouts);
  double last = 0.0;
  for (const auto& [stage, rollouts] : kPlayed) {
    plan.begin(stage, played);
    for (const long end = played + rollouts; played < end; ++played) {
      const double shown = plan.done(played);
      EXPECT_GE(shown, last);
      EXPECT_NEAR(shown, static_cast<double>(played) / all, 0.05) << played;
      last = shown;
    }
  }
}

TEST(MotionPlan, NeverFallsWhereAStageTakesLonger) {
  MotionPlan plan(132, 10, 99, 34);
  double last = 0.0;
  plan.begin(MotionPlan::kPlain, 0);
  for (long played = 0; played < 20000; played += 100) {
    const double shown = plan.done(played);
    EXPECT_GE(shown, last);
    EXPECT_LT(shown, 1.0);
    last = shown;
  }
  plan.begin(MotionPlan::kScan, 20000);
  EXPECT_GE(plan.done(20000), last);
}

}  // namespace
}  // namespace simgap
