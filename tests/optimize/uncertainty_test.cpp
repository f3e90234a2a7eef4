#include <gtest/gtest.h>

#include "simgap/optimize/uncertainty.h"

namespace simgap {
namespace {

TEST(Uncertainty, APartKeepsItsOwnRowsAndColumns) {
  Uncertainty all;
  for (const char* name : {"a", "b", "c"}) {
    Estimate estimate;
    estimate.name = name;
    all.estimates.push_back(estimate);
  }
  all.covariance.resize(3, 3);
  all.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  all.correlation = 0.1 * all.covariance;
  all.n_effective = 7.0;
  const Uncertainty part = partOf(all, 1, 3);
  ASSERT_EQ(part.estimates.size(), 2u);
  EXPECT_EQ(part.estimates[0].name, "b");
  EXPECT_EQ(part.covariance, (Eigen::Matrix2d() << 5, 6, 6, 9).finished());
  EXPECT_EQ(part.correlation, 0.1 * part.covariance);
  EXPECT_EQ(part.n_effective, 7.0);
}

}  // namespace
}  // namespace simgap
