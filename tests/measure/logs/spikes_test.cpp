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
    EXPECT_TRUE(findSpikes(s.time, s.values, kMotionSpikes).empty()) << quantum;
  }
}

/// What a drive can do is no spike, however sudden: a slip to elsewhere, a blow, a start, there and back in 0.1 s.
TEST(Spikes, SuddenMotionIsNone) {
  for (const double size : {0.05, 0.2, 1.0, 5.0}) {
    for (int motion = 0; motion < 4; ++motion) {
      Signal s = encoder(1e-3);
      for (std::size_t i = 500; i < s.values.size(); ++i) {
        const double after = s.time[i] - s.time[499];
        s.values[i] += motion == 0   ? size
                       : motion == 1 ? 10.0 * size * after
                       : motion == 2 ? 100.0 * size * after * after
                                     : size * std::pow(std::sin(std::numbers::pi * std::min(after, 0.1) / 0.1), 2);
      }
      EXPECT_TRUE(findSpikes(s.time, s.values, kMotionSpikes).empty()) << size << " motion " << motion;
      EXPECT_TRUE(findSpikes(s.time, s.values, kEffortSpikes).empty()) << size << " motion " << motion;
    }
  }
}

TEST(Spikes, AreFoundAndPutRight) {
  const Signal clean = encoder(1e-3);
  Signal s = clean;
  s.values[100] += 0.5;
  s.values[700] -= 2.0;
  std::vector<double> none;
  const SearchedChannel channels[] = {{"effort", &s.values, kEffortSpikes}, {"load", &none, kEffortSpikes}};
  const std::vector<ChannelSpikes> found = repairSpikes(s.time, std::vector<int>(s.time.size(), 0), channels);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].channel, "effort");
  EXPECT_THAT(found[0].rows, testing::ElementsAre(100u, 700u));
  for (const std::size_t i : {100u, 700u}) EXPECT_NEAR(s.values[i], clean.values[i], 0.005);
}

/// Wherever the second stands: of a position both are found, of an effort neither is, which may change like that.
TEST(Spikes, OfAPositionTwoMayStandNearEachOther) {
  const Signal clean = encoder(1e-3);
  for (const std::size_t apart : {1u, 2u, 3u, 4u, 5u}) {
    for (const double second : {-2.0, 0.4, 0.5, 3.0}) {
      Signal s = clean;
      s.values[300] += 0.5;
      s.values[300 + apart] += second;
      const std::vector<Spike> found = findSpikes(s.time, s.values, kMotionSpikes);
      ASSERT_EQ(found.size(), 2u) << apart << " rows apart, " << second;
      for (const Spike& spike : found) EXPECT_NEAR(spike.likely, clean.values[spike.row], 0.02);
      if (apart > 2) continue;
      EXPECT_TRUE(findSpikes(s.time, s.values, kEffortSpikes).empty()) << apart;
    }
  }
}

}  // namespace
}  // namespace simgap
