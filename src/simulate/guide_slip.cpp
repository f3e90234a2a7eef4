#include "guide_slip.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace simgap {
namespace {

constexpr int kMostSteps = 50;
constexpr int kMostParts = 30;      // looked at along a step
constexpr double kSettled = 1e-8;   // [m/s]: no slip changes by more in the last step, and after it by its square
constexpr double kLevelled = 0.05;  // of the slope at its beginning, where a search along a step ends

/// a x = b for a symmetric positive definite a, of which the lower half is read and overwritten (Cholesky). Small,
/// without memory of its own. \param[in,out] x  b, then x
void solveInPlace(Eigen::MatrixXd& a, Eigen::VectorXd& x) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) {
      double sum = a(i, j);
      for (Eigen::Index k = 0; k < j; ++k) sum -= a(i, k) * a(j, k);
      a(i, j) = i == j ? std::sqrt(sum) : sum / a(j, j);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) x[i] -= a(i, k) * x[k];
    x[i] /= a(i, i);
  }
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    for (Eigen::Index k = i + 1; k < n; ++k) x[i] -= a(k, i) * x[k];
    x[i] /= a(i, i);
  }
}

}  // namespace

GuideSlip::GuideSlip(Eigen::Index degrees_of_freedom, std::size_t lines)
    : lines_(lines, {Eigen::VectorXd::Zero(degrees_of_freedom), 0.0, 0.0, 0.0, 0.0}),
      curvature_(Eigen::MatrixXd::Zero(degrees_of_freedom, degrees_of_freedom)),
      at_(Eigen::VectorXd::Zero(degrees_of_freedom)),
      step_(at_),
      push_(at_) {}

void GuideSlip::add(const Eigen::VectorXd& row, double most, double creep) {
  assert(used_ < lines_.size() && most > 0.0 && creep > 0.0);
  Line& line = lines_[used_++];
  line.row = row;
  line.most = most;
  line.creep = creep;
}

/// df/dt at v + t step.
double GuideSlip::slopeAlong(double part) const {
  double slope = slope_of_bodies_ + part * bend_of_bodies_;
  for (std::size_t i = 0; i < used_; ++i) {
    const Line& line = lines_[i];
    const double slip = line.slip + part * line.by_step;
    slope += line.most * line.by_step * slip / std::sqrt(slip * slip + line.creep * line.creep);
  }
  return slope;
}

/// The part of a step, at most all of it, after which f no longer falls: between two parts of which one is on either
/// side, halved or cut where the straight line between their slopes meets 0, in turn.
double GuideSlip::leastAlong() const {
  const double first = slopeAlong(0.0);
  double low = 0.0, high = 1.0, slope_low = first, slope_high = slopeAlong(1.0);
  if (!(first < 0.0 && slope_high > kLevelled * -first)) return 1.0;  // at the end rounding may make it rise at once
  double part = 1.0;
  for (int i = 0; i < kMostParts; ++i) {
    part = i % 2 == 0 ? low + (high - low) * slope_low / (slope_low - slope_high) : 0.5 * (low + high);
    const double slope = slopeAlong(part);
    if (std::abs(slope) <= kLevelled * -first) break;
    (slope > 0.0 ? high : low) = part;
    (slope > 0.0 ? slope_high : slope_low) = slope;
  }
  return part;
}

int GuideSlip::solve(const Eigen::MatrixXd& inertia, const Eigen::VectorXd& near, Eigen::VectorXd& v) {
  at_ = near;
  for (std::size_t i = 0; i < used_; ++i) lines_[i].slip = lines_[i].row.dot(at_);
  int steps = 0;
  while (steps < kMostSteps) {
    ++steps;
    curvature_ = inertia;
    push_ = v - at_;
    step_.noalias() = inertia.lazyProduct(push_);  // minus the gradient, then the step
    slope_of_bodies_ = 0.0;
    push_ = step_;
    for (std::size_t i = 0; i < used_; ++i) {
      const Line& line = lines_[i];
      const double square = line.slip * line.slip + line.creep * line.creep, root = std::sqrt(square);
      step_ -= (line.most * line.slip / root) * line.row;
      const double bend = line.most * line.creep * line.creep / (square * root);
      for (Eigen::Index j = 0; j < step_.size(); ++j) curvature_.col(j) += (bend * line.row[j]) * line.row;
    }
    solveInPlace(curvature_, step_);
    double largest = 0.0;
    for (std::size_t i = 0; i < used_; ++i) {
      lines_[i].by_step = lines_[i].row.dot(step_);
      largest = std::max(largest, std::abs(lines_[i].by_step));
    }
    slope_of_bodies_ = -push_.dot(step_);
    push_.noalias() = inertia.lazyProduct(step_);
    bend_of_bodies_ = push_.dot(step_);
    const double part = leastAlong();
    at_ += part * step_;
    for (std::size_t i = 0; i < used_; ++i) lines_[i].slip += part * lines_[i].by_step;
    if (!(largest > kSettled)) break;
  }
  v = at_;
  return steps;
}

}  // namespace simgap
