#include "simgap/optimize/row_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <random>

namespace simgap {
namespace {

constexpr Eigen::Index kRows = 120;

/// y = a + b x, or with a decay a exp(-b x), at x in [0, 3].
class Curve : public RowModel {
 public:
  Curve(bool decays, Eigen::VectorXd measured, double upper) : decays_(decays), measured_(std::move(measured)) {
    parameters_ = {{"a", "1", -10.0, 10.0, false}, {"b", "1", -10.0, upper, false}};
  }

  static Eigen::VectorXd x() { return Eigen::VectorXd::LinSpaced(kRows, 0.0, 3.0); }

  const std::vector<ParameterSpec>& parameters() const override { return parameters_; }
  Eigen::Index rows() const override { return kRows; }
  void evaluate(std::span<const double> theta, Eigen::VectorXd& residual, Eigen::MatrixXd* jacobian) const override {
    const Eigen::ArrayXd x = Curve::x(), e = (-theta[1] * x).exp(), one = Eigen::ArrayXd::Ones(kRows);
    Eigen::ArrayXXd slopes(kRows, 2);
    if (decays_) {
      slopes << e, -theta[0] * x * e;
      residual = (theta[0] * e).matrix() - measured_;
    } else {
      slopes << one, x;
      residual = (theta[0] + theta[1] * x).matrix() - measured_;
    }
    if (jacobian != nullptr) *jacobian = slopes.matrix();
  }

 private:
  bool decays_;
  Eigen::VectorXd measured_;
  std::vector<ParameterSpec> parameters_;
};

Eigen::VectorXd noisy(const Eigen::ArrayXd& y) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.05);
  Eigen::VectorXd measured = y.matrix();
  for (double& value : measured) value += noise(random);
  return measured;
}

Eigen::VectorXd line() { return noisy(0.5 + 0.3 * Curve::x().array()); }

TEST(RowFit, IsLeastSquaresOfTheBlocksAlone) {
  const Curve model(false, line(), 10.0);
  const std::vector<Block> blocks = {{0, 30}, {70, 110}};
  const RowFit fit = fitRows(model, blocks, {0.0, 0.0});
  Eigen::MatrixXd design(70, 2);
  Eigen::VectorXd y(70);
  const Eigen::VectorXd x = Curve::x(), measured = line();
  design.col(0).setOnes();
  design.col(1) << x.segment(0, 30), x.segment(70, 40);
  y << measured.segment(0, 30), measured.segment(70, 40);
  const Eigen::VectorXd expected = design.colPivHouseholderQr().solve(y);
  EXPECT_NEAR(fit.theta[0], expected[0], 1e-9);
  EXPECT_NEAR(fit.theta[1], expected[1], 1e-9);
  EXPECT_NEAR(fit.cost, (design * expected - y).squaredNorm(), 1e-12);
}

TEST(RowFit, OneStepOfALineIsItsMinimum) {
  const Curve model(false, line(), 10.0);
  const std::vector<Block> all = {{0, kRows}};
  const std::vector<double> far = {-3.0, 4.0};
  EXPECT_NEAR(linearisedCost(model, all, far), fitRows(model, all, far).cost, 1e-6);
}

TEST(RowFit, EndsOnABoundWithTheRestAtItsBest) {
  const Curve model(true, noisy(2.0 * (-1.5 * Curve::x().array()).exp()), 1.0);
  const std::vector<Block> all = {{0, kRows}};
  const RowFit fit = fitRows(model, all, {1.0, 0.1});
  EXPECT_EQ(fit.theta[1], 1.0);
  const Eigen::VectorXd e = (-Curve::x().array()).exp().matrix();
  const Eigen::VectorXd measured = noisy(2.0 * (-1.5 * Curve::x().array()).exp());
  EXPECT_NEAR(fit.theta[0], e.dot(measured) / e.squaredNorm(), 1e-6);
}

TEST(RowFit, AStartOutsideTheBoundsIsMovedIntoThem) {
  const Curve model(true, noisy(2.0 * (-0.5 * Curve::x().array()).exp()), 1.0);
  const std::vector<Block> all = {{0, kRows}};
  EXPECT_EQ(fitRows(model, all, {1.0, 5.0}, {.max_iterations = 0}).theta[1], 1.0);
}

TEST(RowFit, CovarianceOfIndependentRowsIsWhites) {
  const Curve model(false, line(), 10.0);
  std::vector<Block> rows;
  for (std::size_t i = 0; i < kRows; ++i) rows.push_back({i, i + 1});
  const std::vector<Block> all = {{0, kRows}};
  const RowFit fit = fitRows(model, all, {0.0, 0.0});
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  model.evaluate(fit.theta, residual, &jacobian);
  const Eigen::MatrixXd inverse = (jacobian.transpose() * jacobian).inverse();
  const Eigen::MatrixXd scores = jacobian.transpose() * residual.cwiseAbs2().asDiagonal() * jacobian;
  const Eigen::MatrixXd expected = inverse * scores * inverse * (kRows / (kRows - 2.0));  // White 1980, small samples
  EXPECT_LT((blockCovariance(model, rows, RowEvaluation(model, fit.theta)) - expected).norm(), 1e-8 * expected.norm());
}

}  // namespace
}  // namespace simgap
