#include "simgap/optimize/cma_es.h"

#include <gtest/gtest.h>

namespace simgap {
namespace {

double shiftedEllipsoid(const std::vector<double>& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += static_cast<double>(1 + 10 * i) * (x[i] - 2.0) * (x[i] - 2.0);
  return sum;
}

TEST(CmaEs, FindsTheMinimumOfAnEllipsoid) {
  double best = 0.0;
  int generations = 0;
  minimiseByCmaEs(shiftedEllipsoid, 10, {24, 300, 1.0, 1}, [&](const CmaEsGeneration& generation) {
    best = generation.best_objective;
    EXPECT_EQ(generation.best_objective, shiftedEllipsoid(generation.best));
    EXPECT_EQ(generation.objectives.size(), 24u);
    ++generations;
    return best < 1e-12;
  });
  EXPECT_LT(best, 1e-12);
  EXPECT_LT(generations, 300);
}

TEST(CmaEs, RepeatsItselfWithTheSameSeedOnly) {
  const auto run = [](std::uint64_t seed) {
    double best = 0.0;
    minimiseByCmaEs(shiftedEllipsoid, 5, {12, 10, 1.0, seed}, [&](const CmaEsGeneration& generation) {
      best = generation.best_objective;
      return false;
    });
    return best;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

}  // namespace
}  // namespace simgap
