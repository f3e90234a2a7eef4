#include "simgap/optimize/trace_norm_logistic.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

namespace simgap::test {
namespace {

struct TraceNormCase {
  std::vector<Eigen::MatrixXd> matrices;
  Eigen::VectorXd labels;
};

/// Matrices of noise, of which one direction is louder where the label is +1.
TraceNormCase drawCase(int dimension, int count, double effect) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd direction(dimension);
  for (double& d : direction) d = normal(random);
  direction.normalize();
  TraceNormCase drawn;
  drawn.labels.resize(count);
  for (int t = 0; t < count; ++t) {
    drawn.labels[t] = t % 2 == 0 ? 1.0 : -1.0;
    Eigen::MatrixXd noise(dimension, dimension);
    for (double& v : noise.reshaped()) v = normal(random);
    drawn.matrices.push_back(0.5 * (noise + noise.transpose()) +
                             effect * drawn.labels[t] * direction * direction.transpose());
  }
  return drawn;
}

/// As the paper writes it, eq. (4).
double paperObjective(const TraceNormCase& drawn, const Eigen::MatrixXd& weights, double bias, double penalty) {
  double sum = 0.0;
  for (std::size_t t = 0; t < drawn.matrices.size(); ++t) {
    const double log_odds = (weights * drawn.matrices[t]).trace() + bias;
    sum += std::log(1.0 + std::exp(-drawn.labels[t] * log_odds));
  }
  return sum + penalty * Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(weights).eigenvalues().cwiseAbs().sum();
}

TEST(TraceNormLogistic, PackedRowsMultiplyAsMatricesDo) {
  const TraceNormCase drawn = drawCase(5, 2, 1.0);
  const Eigen::MatrixXd packed = packSymmetric(drawn.matrices);
  EXPECT_NEAR(packed.row(0).dot(packed.row(1)), (drawn.matrices[0] * drawn.matrices[1]).trace(), 1e-12);
  EXPECT_TRUE(unpackSymmetric(packed.row(0), 5).isApprox(drawn.matrices[0], 1e-14));
}

/// The gap that is claimed is one: nothing nearby, and nothing drawn, is lower by more.
TEST(TraceNormLogistic, NothingIsLowerByMoreThanTheGap) {
  const TraceNormCase drawn = drawCase(6, 60, 1.0);
  const Eigen::MatrixXd packed = packSymmetric(drawn.matrices);
  const double penalty = 4.0;
  const TraceNormFit fit = fitTraceNormLogistic(packed, drawn.labels, 6, penalty);
  ASSERT_TRUE(fit.converged);
  EXPECT_LE(fit.gap, 1e-6);
  const Eigen::MatrixXd weights = unpackSymmetric(fit.weights, 6);
  EXPECT_NEAR(paperObjective(drawn, weights, fit.bias, penalty), fit.objective, 1e-9 * fit.objective);
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 2000; ++k) {
    const double size = std::pow(10.0, -4.0 * k / 2000.0);
    Eigen::MatrixXd move(6, 6);
    for (double& v : move.reshaped()) v = size * normal(random);
    EXPECT_GE(paperObjective(drawn, weights + move + move.transpose(), fit.bias + size * normal(random), penalty),
              (1.0 - 1e-6) * fit.objective);
  }
}

/// At the least objective the slope of the loss is penalty U V^T along the weights, and no steeper elsewhere.
TEST(TraceNormLogistic, TheSlopeAtTheEndIsThePenaltysOwn) {
  const TraceNormCase drawn = drawCase(6, 60, 1.5);
  const double penalty = 6.0;
  const TraceNormFit fit =
      fitTraceNormLogistic(packSymmetric(drawn.matrices), drawn.labels, 6, penalty, {1e-10, 100'000});
  ASSERT_TRUE(fit.converged);
  const Eigen::MatrixXd weights = unpackSymmetric(fit.weights, 6);
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(6, 6);
  double bias_slope = 0.0;
  for (std::size_t t = 0; t < drawn.matrices.size(); ++t) {
    const double q = drawn.labels[t];
    const double alpha = 1.0 / (1.0 + std::exp(q * ((weights * drawn.matrices[t]).trace() + fit.bias)));
    slope += q * alpha * drawn.matrices[t];
    bias_slope += q * alpha;
  }
  EXPECT_NEAR(bias_slope, 0.0, 1e-8);
  EXPECT_LE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(slope).eigenvalues().cwiseAbs().maxCoeff(),
            penalty * (1.0 + 1e-4));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(weights);
  int kept = 0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (std::abs(eigen.eigenvalues()[k]) < 1e-6) continue;
    ++kept;
    const Eigen::VectorXd v = eigen.eigenvectors().col(k);
    EXPECT_NEAR(v.dot(slope * v), std::copysign(penalty, eigen.eigenvalues()[k]), 1e-3 * penalty);
  }
  EXPECT_GT(kept, 0);
  EXPECT_LT(kept, 6);  // few directions: what the penalty is for
}

TEST(TraceNormLogistic, FromTheLargestPenaltyOnNothingIsLeft) {
  const TraceNormCase drawn = drawCase(4, 40, 1.0);
  const Eigen::MatrixXd packed = packSymmetric(drawn.matrices);
  const double largest = largestTraceNormPenalty(packed, drawn.labels, 4);
  EXPECT_EQ(fitTraceNormLogistic(packed, drawn.labels, 4, 1.001 * largest).weights.norm(), 0.0);
  EXPECT_GT(fitTraceNormLogistic(packed, drawn.labels, 4, 0.99 * largest).weights.norm(), 0.0);
}

}  // namespace
}  // namespace simgap::test
