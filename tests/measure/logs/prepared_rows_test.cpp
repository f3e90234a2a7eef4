#include "measure/logs/prepared_rows.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace simgap::test {
namespace {

// In a log that rests for most of its time the usual rate is that of rest: all motion was a jump, and nothing was left.
TEST(Jumps, AreFarAboveTheRatesOfMotion) {
  constexpr Eigen::Index kRows = 1000, kRests = 600, kJump = 800;
  Eigen::ArrayXd rate = Eigen::ArrayXd::Constant(kRows, 1e-6);
  for (Eigen::Index i = kRests; i < kRows; ++i) rate[i] = i % 2 == 0 ? 1.0 : -2.0;
  rate[kJump] = 100.0;
  std::vector<bool> keep(kRows, false);
  std::fill(keep.begin() + kRests, keep.end(), true);
  leaveOutJumps(rate, keep);
  EXPECT_EQ(std::ranges::count(keep, true), kRows - kRests - 9);
  EXPECT_FALSE(keep[kJump - 4] || keep[kJump + 4]);
  EXPECT_TRUE(keep[kJump - 5] && keep[kJump + 5]);
}

}  // namespace
}  // namespace simgap::test
