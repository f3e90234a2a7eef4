#include "simgap/fit/actuators/stribeck_moments.h"

#include <algorithm>
#include <cmath>

#include "simgap/model/friction/friction_evaluation.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kRange = 11.0;  // of log speed below the largest: a factor of 60,000
constexpr Index kWide = 768;     // cells over the range
constexpr Index kNarrow = 16 * kWide;
constexpr Index kFewRows = 8192;  // so many rows are few: each has a narrow cell more or less to itself

}  // namespace

StribeckMoments::StribeckMoments(std::vector<FrictionShape> shapes, double top, Index cells)
    : shapes_(std::move(shapes)), top_(top), cells_(cells) {
  const auto columns = static_cast<Index>(shapes_.size());
  const auto weightOf = [&](Index a, Index b) {
    const FrictionShape one = shapes_[a], two = shapes_[b];
    const int sliding = (one == FrictionShape::kSliding ? 1 : 0) + (two == FrictionShape::kSliding ? 1 : 0);
    const int is_static = (one == FrictionShape::kStatic ? 1 : 0) + (two == FrictionShape::kStatic ? 1 : 0);
    if (sliding + is_static == 0) return kWeights;
    if (sliding + is_static == 1) return sliding == 1 ? kSliding : kStatic;
    return sliding == 2 ? kSlidingSliding : is_static == 2 ? kStaticStatic : kSlidingStatic;
  };
  for (int weight = 0; weight < kWeights; ++weight) {
    first_[weight] = static_cast<Index>(products_.size());
    for (Index a = 0; a < columns; ++a) {
      for (Index b = a; b < columns; ++b) {
        if (weightOf(a, b) == weight) products_.push_back({a, b});
      }
    }
  }
  first_[kWeights] = static_cast<Index>(products_.size());
  always_ = Eigen::MatrixXd::Zero(columns, columns);
}

StribeckMoments::StribeckMoments(std::vector<FrictionShape> shapes, double top)
    : StribeckMoments(std::move(shapes), top, kWide) {
  makeBins(cells_);
}

StribeckMoments::StribeckMoments(std::vector<FrictionShape> shapes, const Eigen::ArrayXd& log_speed)
    : StribeckMoments(std::move(shapes), log_speed.maxCoeff(), log_speed.size() > kFewRows ? kWide : kNarrow) {
  std::vector<Index> bins(static_cast<std::size_t>(cells_), -1);
  for (const double s : log_speed) bins[cellOf(s)] = 0;
  Index count = 0;
  for (Index& bin : bins) {
    if (bin == 0) bin = count++;
  }
  bin_of_cell_ = std::make_shared<const std::vector<Index>>(std::move(bins));
  makeBins(count);
}

void StribeckMoments::makeBins(Index bins) {
  if (products_.empty()) return;
  count_ = sum_log_ = Eigen::VectorXd::Zero(bins);
  mixed_ = Eigen::MatrixXd::Zero(bins, products_.size());
}

Index StribeckMoments::cellOf(double log_speed) const {
  const double place = (log_speed - top_ + kRange) / kRange * static_cast<double>(cells_);
  return std::min(static_cast<Index>(std::max(place, 0.0)), cells_ - 1);
}

void StribeckMoments::add(const Eigen::Ref<const Eigen::ArrayXd>& log_speed,
                          const Eigen::Ref<const Eigen::ArrayXXd>& x) {
  always_.noalias() += x.matrix().transpose() * x.matrix();
  if (products_.empty()) return;
  Eigen::VectorXd u(x.cols());
  for (Index i = 0; i < x.rows(); ++i) {
    u = x.row(i);
    const Index cell = cellOf(log_speed[i]);
    const Index bin = bin_of_cell_ ? (*bin_of_cell_)[cell] : cell;
    sum_log_[bin] += log_speed[i];
    count_[bin] += 1.0;
    double* sum = mixed_.data() + bin;
    for (const Product& product : products_) {
      *sum += u[product.a] * u[product.b];
      sum += mixed_.rows();
    }
  }
}

void StribeckMoments::add(const StribeckMoments& other, double sign) {
  always_ += sign * other.always_;
  count_ += sign * other.count_;
  sum_log_ += sign * other.sum_log_;
  mixed_ += sign * other.mixed_;
}

Eigen::MatrixXd StribeckMoments::gram(double v_s, double delta) const {
  if (products_.empty()) return always_;
  const Eigen::ArrayXd log_speed = sum_log_.array() / count_.array().max(1.0);  // of each bin's rows
  const Eigen::ArrayXd log_exponent = delta * (log_speed - std::log(v_s));
  // Exponentials are needed where E changes only, which for a steep curve is a small part of the bins: below it is 1 to
  // 1e-10, above it 0 to 1e-17.
  constexpr double kRest = -23.0, kGone = 3.7;
  const Index bins = log_exponent.size();
  Index low = 0, high = bins;
  while (low < bins && log_exponent[low] < kRest) ++low;
  while (high > low && log_exponent[high - 1] > kGone) --high;
  Eigen::ArrayXd is_static(bins), sliding(bins);
  is_static.head(low) = 1.0;
  sliding.head(low) = 0.0;
  is_static.tail(bins - high) = 0.0;
  sliding.tail(bins - high) = 1.0;
  const auto [exponent, value] = stribeckFactor(log_speed.segment(low, high - low), v_s, delta);
  is_static.segment(low, high - low) = value;
  // 1 - exp(-x) without cancellation for small x.
  sliding.segment(low, high - low) = (exponent < 1e-5).select(exponent * (1.0 - 0.5 * exponent), 1.0 - value);
  Eigen::MatrixXd gram = always_;
  const auto sum = [&](Weight weight, const Eigen::ArrayXd& values) {
    for (Index k = first_[weight]; k < first_[weight + 1]; ++k) {
      const auto [a, b] = products_[k];
      gram(a, b) = gram(b, a) = mixed_.col(k).dot(values.matrix());
    }
  };
  sum(kSliding, sliding);
  sum(kStatic, is_static);
  sum(kSlidingSliding, sliding * sliding);
  sum(kSlidingStatic, sliding * is_static);
  sum(kStaticStatic, is_static * is_static);
  return gram;
}

}  // namespace simgap
