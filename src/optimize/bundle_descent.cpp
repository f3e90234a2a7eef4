#include "simgap/optimize/bundle_descent.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kTangents = 16;  // the latest
constexpr double kHonoured = 0.1;      // share of what a step was promised that it must keep
constexpr double kShort = 0.1;         // of a step: a kink was in its way
constexpr double kShortest = 1e-3;     // of a step: what lies so near shows the other side of a kink

struct Tangent {
  VectorXd x, slope;
  double value;
  /// e_k >= 0; where the function is not convex, what bends down is not believed.
  double error(const VectorXd& from, double value_there) const {
    return std::max(0.0, value_there - value - slope.dot(from - x));
  }
};

/// Minimises 1/2 l^T Q l + e^T l over the simplex, two weights at a time.
VectorXd simplexWeights(const MatrixXd& q, const VectorXd& e) {
  const Index n = e.size();
  VectorXd weights = VectorXd::Zero(n);
  Index best;
  (0.5 * q.diagonal() + e).minCoeff(&best);
  weights[best] = 1.0;
  VectorXd slope = q.col(best) + e;
  const double enough = 1e-9 * (1.0 + q.diagonal().maxCoeff());
  for (int k = 0; k < 1000; ++k) {
    Index to, from = -1;
    slope.minCoeff(&to);
    for (Index i = 0; i < n; ++i) {
      if (weights[i] > 0.0 && (from < 0 || slope[i] > slope[from])) from = i;
    }
    const double gain = slope[from] - slope[to];
    if (gain < enough) break;
    const double bend = q(to, to) + q(from, from) - 2.0 * q(to, from);
    const double moved = bend > 0.0 ? std::min(weights[from], gain / bend) : weights[from];
    weights[to] += moved;
    weights[from] = moved < weights[from] ? weights[from] - moved : 0.0;
    slope += moved * (q.col(to) - q.col(from));
  }
  return weights;
}

class Bundle {
 public:
  Bundle(const KinkedFunction& function, const VectorXd& x) : function_(function) {
    result_.x = x;
    result_.value = function.value(x);
  }

  BundleDescent descend(double enough, int max_steps) {
    if (!std::isfinite(result_.value)) return result_;
    moveTo(result_.x, result_.value);
    for (; result_.steps < max_steps; ++result_.steps) {
      const VectorXd step = modelStep();
      if (promised_ < enough || !tryStep(step)) break;
    }
    return result_;
  }

 private:
  void moveTo(const VectorXd& x, double value) {
    VectorXd slope;
    result_.x = x;
    result_.value = value;
    function_.linearise(x, result_.curvature, slope);
    add({x, std::move(slope), value});
  }
  void add(Tangent tangent) {
    if (tangents_.size() == kTangents) tangents_.erase(tangents_.begin());
    tangents_.push_back(std::move(tangent));
  }

  /// d of the model; what stands at a bound and would leave it stays.
  VectorXd modelStep() {
    std::vector<bool> held(static_cast<std::size_t>(result_.x.size()), false);
    for (;;) {
      const VectorXd step = freeStep(held);
      bool more = false;
      for (Index i = 0; i < step.size(); ++i) {
        const bool leaves = (step[i] < 0.0 && result_.x[i] <= function_.lower[i]) ||
                            (step[i] > 0.0 && result_.x[i] >= function_.upper[i]);
        if (!leaves || held[i]) continue;
        held[i] = more = true;
      }
      if (!more) return step;
    }
  }

  VectorXd freeStep(const std::vector<bool>& held) {
    const auto count = static_cast<Index>(tangents_.size());
    MatrixXd curvature = result_.curvature;
    MatrixXd slopes(result_.x.size(), count);
    VectorXd errors(count);
    for (Index k = 0; k < count; ++k) {
      slopes.col(k) = tangents_[k].slope;
      errors[k] = tangents_[k].error(result_.x, result_.value);
    }
    for (Index i = 0; i < result_.x.size(); ++i) {
      if (!held[i]) continue;
      slopes.row(i).setZero();
      curvature.row(i).setZero();
      curvature.col(i).setZero();
      curvature(i, i) = 1.0;
    }
    const MatrixXd steps = curvature.llt().solve(slopes);  // N^-1 G
    const MatrixXd q = slopes.transpose() * steps;
    const VectorXd weights = simplexWeights(q, errors);
    promised_ = 0.5 * weights.dot(q * weights) + errors.dot(weights);
    return -steps * weights;
  }

  /// Goes, or learns what lies there. \returns whether either was of use
  bool tryStep(const VectorXd& step) {
    VectorXd beyond;  // the last point that was no better
    double value_beyond = 0.0;
    for (double share = 1.0; share > kShortest * kShortest; share *= 0.5) {
      const VectorXd there = (result_.x + share * step).cwiseMax(function_.lower).cwiseMin(function_.upper);
      const double value = function_.value(there);
      if (value < result_.value - kHonoured * share * promised_) {
        if (share < kShort && std::isfinite(value_beyond)) learn(beyond, value_beyond);
        moveTo(there, value);
        return true;
      }
      if (share < kShortest && std::isfinite(value)) {
        learn(there, value);
        // What promises the same decrease as the model has taught nothing.
        return tangents_.back().slope.dot(step) > -promised_;
      }
      beyond = there;
      value_beyond = value;
    }
    return false;
  }
  void learn(const VectorXd& x, double value) {
    MatrixXd curvature;
    VectorXd slope;
    function_.linearise(x, curvature, slope);
    add({x, slope, value});
  }

  const KinkedFunction& function_;
  BundleDescent result_;
  std::vector<Tangent> tangents_;
  double promised_ = 0.0;  ///< by which the model says the last step lowers the function
};

}  // namespace

BundleDescent descendBundle(const KinkedFunction& function, const VectorXd& x, double enough, int max_steps) {
  return Bundle(function, x).descend(enough, max_steps);
}

}  // namespace simgap
