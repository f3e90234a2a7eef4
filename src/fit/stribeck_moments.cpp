#include "simgap/fit/stribeck_moments.h"

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

using Eigen::Index;

constexpr Index kBins = 768;
constexpr double kRange = 11.0;  // of log speed below the largest: a factor of 60,000

}  // namespace

StribeckMoments::StribeckMoments(std::vector<FrictionShape> shapes, double top)
    : shapes_(std::move(shapes)), top_(top) {
  const auto columns = static_cast<Index>(shapes_.size());
  for (Index j = 0; j < columns; ++j) {
    if (shapes_[static_cast<std::size_t>(j)] != FrictionShape::kAlways) shaped_.push_back(j);
  }
  const Index bins = shaped_.empty() ? 0 : kBins;
  always_ = Eigen::MatrixXd::Zero(columns, columns);
  count_ = sum_log_ = Eigen::VectorXd::Zero(bins);
  mixed_ = Eigen::MatrixXd::Zero(columns * static_cast<Index>(shaped_.size()), bins);
}

void StribeckMoments::add(const Eigen::Ref<const Eigen::ArrayXd>& log_speed,
                          const Eigen::Ref<const Eigen::ArrayXXd>& x) {
  always_.noalias() += x.matrix().transpose() * x.matrix();
  if (shaped_.empty()) return;
  const auto s = static_cast<Index>(shaped_.size());
  Eigen::VectorXd u(x.cols()), w(s);
  for (Index i = 0; i < x.rows(); ++i) {
    u = x.row(i);
    for (Index k = 0; k < s; ++k) w[k] = u[shaped_[static_cast<std::size_t>(k)]];
    const double place = (log_speed[i] - top_ + kRange) / kRange * static_cast<double>(kBins);
    const Index bin = std::min(static_cast<Index>(std::max(place, 0.0)), kBins - 1);
    sum_log_[bin] += log_speed[i];
    count_[bin] += 1.0;
    Eigen::Map<Eigen::MatrixXd>(mixed_.col(bin).data(), u.size(), s).noalias() += u * w.transpose();
  }
}

void StribeckMoments::add(const StribeckMoments& other, double sign) {
  always_ += sign * other.always_;
  count_ += sign * other.count_;
  sum_log_ += sign * other.sum_log_;
  mixed_ += sign * other.mixed_;
}

Eigen::MatrixXd StribeckMoments::gram(double v_s, double delta) const {
  if (shaped_.empty()) return always_;
  const Eigen::ArrayXd log_speed = sum_log_.array() / count_.array().max(1.0);
  const Eigen::ArrayXd exponent = (delta * (log_speed - std::log(v_s))).exp();
  const Eigen::ArrayXd fixed = (-exponent).exp();
  // 1 - exp(-x) without cancellation for small x.
  const Eigen::ArrayXd sliding = (exponent < 1e-5).select(exponent * (1.0 - 0.5 * exponent), 1.0 - fixed);
  const Index columns = always_.rows();
  Eigen::MatrixXd weights(count_.size(), 5);  // by shape: 1 - E, E, and their products
  weights << sliding, fixed, sliding * sliding, sliding * fixed, fixed * fixed;
  const Eigen::MatrixXd sums = mixed_ * weights;
  Eigen::MatrixXd gram = always_;
  for (std::size_t k = 0; k < shaped_.size(); ++k) {
    const Index column = shaped_[k];
    const bool is_static = shapes_[static_cast<std::size_t>(column)] == FrictionShape::kStatic;
    const Index first = static_cast<Index>(k) * columns;
    for (Index j = 0; j < columns; ++j) {
      const FrictionShape other = shapes_[static_cast<std::size_t>(j)];
      const Index weight = other == FrictionShape::kAlways
                               ? (is_static ? 1 : 0)
                               : 2 + (is_static ? 1 : 0) + (other == FrictionShape::kStatic ? 1 : 0);
      gram(j, column) = gram(column, j) = sums(first + j, weight);
    }
  }
  return gram;
}

}  // namespace simgap
