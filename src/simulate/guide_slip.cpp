#include "guide_slip.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "invert_in_place.h"

namespace simgap {
namespace {

constexpr int kMostSteps = 50;
constexpr int kMostParts = 30;      // looked at along a step
constexpr double kSettled = 1e-8;   // [m/s]: no slip changes by more in the last step, and after it by its square
constexpr double kLevelled = 0.05;  // of the slope at its beginning, where a search along a step ends

}  // namespace

GuideSlip::GuideSlip(Eigen::Index degrees_of_freedom, std::size_t lines)
    : lines_(lines, {Eigen::VectorXd::Zero(degrees_of_freedom), 0.0, 0.0, 0.0, 0.0}),
      mobility_(Eigen::MatrixXd::Zero(degrees_of_freedom, degrees_of_freedom)),
      at_(Eigen::VectorXd::Zero(degrees_of_freedom)),
      step_(at_),
      downhill_(at_),
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
    mobility_ = inertia;  // the second derivative, then its inverse
    push_ = v - at_;
    downhill_.noalias() = inertia.lazyProduct(push_);
    push_ = downhill_;
    for (std::size_t i = 0; i < used_; ++i) {
      const Line& line = lines_[i];
      const double square = line.slip * line.slip + line.creep * line.creep, root = std::sqrt(square);
      downhill_ -= (line.most * line.slip / root) * line.row;
      const double bend = line.most * line.creep * line.creep / (square * root);
      for (Eigen::Index j = 0; j < downhill_.size(); ++j) mobility_.col(j) += (bend * line.row[j]) * line.row;
    }
    invertInPlace(mobility_);
    step_.noalias() = mobility_.lazyProduct(downhill_);
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
