// Samples that stand alone, and what only looks like them.
#include "simgap/measure/logs/spikes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace simgap {
namespace {

struct Signal {
  std::vector<double> time, values;
};

/// A sine of 0.5 Hz at 50 Hz, read by an encoder with `quantum` steps; the stamps jitter.
Signal encoder(double quantum) {
  Signal s;
  for (int i = 0; i < 1000; ++i) {
    s.time.push_back(0.02 * i + 0.004 * std::sin(7.0 * i));
    const double angle = 3.0 * std::sin(std::numbers::pi * s.time.back());
    s.values.push_back(quantum > 0.0 ? quantum * std::round(angle / quantum) : angle);
  }
  return s;
}

TEST(Spikes, NoneInMotionThatWasOnlyRoundedOff) {
  for (const double quantum : {0.0, 1e-3, 0.03}) {
    const Signal s = encoder(quantum);
    EXPECT_TRUE(findSpikes(s.time, s.values).empty()) << quantum;
  }
}

TEST(Spikes, AJumpIsNoSpike) {
  Signal s = encoder(1e-3);
  for (std::size_t i = 500; i < s.values.size(); ++i) s.values[i] += 1.0;
  EXPECT_TRUE(findSpikes(s.time, s.values).empty());
}

TEST(Spikes, AreFoundAndPutRight) {
  const Signal clean = encoder(1e-3);
  Signal s = clean;
  s.values[100] += 0.5;
  s.values[700] -= 2.0;
  EXPECT_THAT(repairSpikes(s.time, std::vector<int>(s.time.size(), 0), s.values), testing::ElementsAre(100u, 700u));
  for (const std::size_t i : {100u, 700u}) EXPECT_NEAR(s.values[i], clean.values[i], 0.02);
}

}  // namespace
}  // namespace simgap
