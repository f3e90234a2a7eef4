#include "simgap/core/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap {
namespace {

TEST(Quantile, IsTheElementWithThatShareBelowIt) {
  const std::vector<double> values = {5.0, 1.0, 4.0, 2.0, 3.0};
  EXPECT_EQ(quantile(values, 0.0), 1.0);
  EXPECT_EQ(quantile(values, 0.19), 1.0);
  EXPECT_EQ(quantile(values, 0.2), 2.0);
  EXPECT_EQ(quantile(values, 0.5), 3.0);
  EXPECT_EQ(quantile(values, 0.99), 5.0);
}

TEST(Median, OfAnEvenNumberLiesBetweenTheTwoInTheMiddle) {
  EXPECT_EQ(median({7.0}), 7.0);
  EXPECT_EQ(median({9.0, -1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 100.0}), 3.0);
  EXPECT_EQ(upperMedian({4.0, 1.0, 2.0, 100.0}), 4.0);
  EXPECT_EQ(upperMedian({9.0, -1.0, 2.0}), 2.0);
}

TEST(RobustDeviation, IsTheStandardDeviationOfNormalValuesAndBlindToOutliers) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, 3.0);
  std::vector<double> values;
  for (int i = 0; i < 100000; ++i) values.push_back(normal(random));
  // Its own standard deviation is 1.17 sd / sqrt(n): 0.011 here.
  EXPECT_NEAR(robustDeviation(values), 3.0, 0.05);
  for (int i = 0; i < 1000; ++i) values[i] = 1e6;
  EXPECT_NEAR(robustDeviation(values), 3.0, 0.1);
}

// Expected values from the tables of Abramowitz & Stegun (26.7, 26.8, 26.2), to their last printed digit.
TEST(StudentQuantile, AgreesWithTheTable) {
  EXPECT_NEAR(studentQuantile(1.0), 12.706, 5e-4);
  EXPECT_NEAR(studentQuantile(2.0), 4.303, 5e-4);
  EXPECT_NEAR(studentQuantile(4.0), 2.776, 5e-4);
  EXPECT_NEAR(studentQuantile(10.0), 2.228, 5e-4);
  EXPECT_NEAR(studentQuantile(60.0), 2.000, 5e-4);
  EXPECT_NEAR(studentQuantile(1e7), 1.959964, 1e-6);
  EXPECT_EQ(studentQuantile(0.0), studentQuantile(1.0));
}

TEST(Correlation, ByHand) {
  const std::vector<double> x = {1.0, 2.0, 3.0}, up = {10.0, 20.0, 30.0}, down = {1.0, 0.0, -1.0},
                            bent = {1.0, 3.0, 2.0};
  EXPECT_DOUBLE_EQ(correlation(x, up), 1.0);
  EXPECT_DOUBLE_EQ(correlation(x, down), -1.0);
  EXPECT_DOUBLE_EQ(correlation(x, bent), 0.5);  // (-1, 0, 1).(-1, 1, 0) / sqrt(2 2)
  EXPECT_EQ(correlation(x, std::vector<double>(3, 7.0)), 0.0);
}

TEST(StudentTail, IsTheQuantilesInverse) {
  for (const double dof : {1.0, 4.0, 60.0}) EXPECT_NEAR(studentTail(studentQuantile(dof), dof), 0.025, 1e-12);
  EXPECT_EQ(studentTail(0.0, 3.0), 0.5);
  EXPECT_EQ(studentTail(std::numeric_limits<double>::infinity(), 3.0), 0.0);
}

TEST(CombinedP, OfOneTestIsItsOwn) {
  for (const double p : {0.0, 1e-300, 1e-20, 1e-8, 0.03, 0.5, 0.97, 1.0}) {
    EXPECT_NEAR(combinedP(std::vector<double>{p}), p, 1e-9 * p) << p;
    EXPECT_NEAR(combinedP(std::vector<double>(3, p)), p, 1e-9 * p) << p;
  }
}

/// Three tests of pure chance: alike, dependent or independent, the combined one keeps its level.
TEST(CombinedP, KeepsItsLevelHoweverTestsDepend) {
  for (const double shared : {0.0, 0.7, 0.99}) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    int at_5 = 0, at_1 = 0;
    constexpr int kTrials = 20000;
    for (int i = 0; i < kTrials; ++i) {
      const double common = std::sqrt(shared) * normal(random);
      std::vector<double> p;
      for (int k = 0; k < 3; ++k) p.push_back(normalTail(common + std::sqrt(1.0 - shared) * normal(random)));
      const double combined = combinedP(p);
      at_5 += combined < 0.05 ? 1 : 0;
      at_1 += combined < 0.01 ? 1 : 0;
    }
    EXPECT_LT(at_5, 0.062 * kTrials) << shared;  // known to be a little liberal at 5 % where tests half depend
    EXPECT_LT(at_1, 0.0125 * kTrials) << shared;
    EXPECT_GT(at_5, 0.04 * kTrials) << shared;
  }
}

TEST(ChiSquaredTail, AgreesWithTheTable) {
  EXPECT_NEAR(chiSquaredTail(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(11.3449, 3), 0.01, 1e-6);
  EXPECT_NEAR(chiSquaredTail(18.4668, 4), 0.001, 3e-8);
  EXPECT_EQ(chiSquaredTail(0.0, 3), 1.0);
  EXPECT_EQ(chiSquaredTail(-1.0, 3), 1.0);
  EXPECT_EQ(chiSquaredTail(1e6, 3), 0.0);
  EXPECT_EQ(chiSquaredTail(INFINITY, 3), 0.0);
}

TEST(NormalTail, AgreesWithTheTableAndWithTheSquareOfItsVariable) {
  EXPECT_NEAR(normalTail(0.0), 0.5, 1e-15);
  EXPECT_NEAR(normalTail(1.959964), 0.025, 1e-8);
  EXPECT_NEAR(normalTail(-1.959964), 0.975, 1e-8);
  for (const double z : {0.1, 1.0, 3.0, 6.0}) {
    EXPECT_NEAR(2.0 * normalTail(z) / chiSquaredTail(z * z, 1), 1.0, 1e-13) << z;
  }
}

}  // namespace
}  // namespace simgap
