/// \file
/// How far a simulated motion is from a judge's, over steps and arms.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <vector>

#include "simgap/simulate/rollout.h"

namespace simgap::test {

/// Largest angle of a joint between the judge and the simulation, per step. [rad]
/// \param apart  at a row of the track, which has one per element of `times`
inline std::vector<double> largestPerStep(
    const ArmModel& model, const MotionCommands& commands, const MotionStart& start, const std::vector<double>& times,
    const std::vector<double>& steps, const std::function<double(const MotionTrack& track, std::size_t row)>& apart) {
  std::vector<double> largest;
  for (const double step : steps) {
    RolloutOptions options;
    options.step = step;
    MotionTrack track;
    EXPECT_TRUE(Rollout(model, options).run(commands, start, times, track).finished);
    largest.push_back(0.0);
    for (std::size_t row = 0; row < times.size(); ++row) largest.back() = std::max(largest.back(), apart(track, row));
  }
  return largest;
}

/// Prints what each step costs over 50 arms. \param differences  of an arm, per step [rad]
/// \returns the largest of all arms, shape (steps) [deg]
inline std::vector<double> studySteps(
    const std::vector<double>& steps,
    const std::function<std::vector<double>(std::uint64_t seed, const std::vector<double>& steps)>& differences) {
  std::vector<std::vector<double>> degrees(steps.size());
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::vector<double> largest = differences(seed, steps);
    for (std::size_t s = 0; s < steps.size(); ++s) degrees[s].push_back(toDegrees(largest[s]));
  }
  std::vector<double> largest;
  for (std::size_t s = 0; s < steps.size(); ++s) {
    std::ranges::sort(degrees[s]);
    std::printf("step %g s: median %.4f deg, 90 %% %.4f deg, largest %.4f deg, within 0.05 deg: %ld of 50\n", steps[s],
                degrees[s][25], degrees[s][45], degrees[s][49],
                std::ranges::count_if(degrees[s], [](double d) { return d <= 0.05; }));
    largest.push_back(degrees[s].back());
  }
  return largest;
}

}  // namespace simgap::test
