#include "robot_search.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSame = 1e-6;      // of a column's squares: what is left of one that others make up
constexpr double kAbsorbed = 1e-4;  // the same of one that is fitted anyway
constexpr double kActs = 0.05;      // of a cause's weighed squares: joints with less show nothing of it

ExtraColumn times(double factor, ExtraColumn column) {
  for (Eigen::ArrayXd& joint : column) joint *= factor;
  return column;
}

ExtraColumn sumOf(ExtraColumn a, const ExtraColumn& b) {
  for (std::size_t c = 0; c < a.size(); ++c) {
    if (b[c].size() == 0) continue;
    if (a[c].size() == 0) {
      a[c] = b[c];
    } else {
      a[c] += b[c];
    }
  }
  return a;
}

}  // namespace

RobotNormal normalOf(const std::vector<JointSums>& sums, const std::vector<std::vector<std::size_t>>& acts, Index size,
                     const std::vector<double>& variance, const std::vector<double>& constants) {
  RobotNormal normal{MatrixXd::Zero(size, size), VectorXd::Zero(size)};
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const MatrixXd& p = sums[c].products;
    const Index known = std::ssize(acts[c]), effort = known + 1;
    const double weight = 1.0 / variance[c];
    for (Index i = 0; i < known; ++i) {
      const auto row = static_cast<Index>(acts[c][i]);
      for (Index k = 0; k < known; ++k) {
        normal.a(row, static_cast<Index>(acts[c][k])) += weight * p(i, k);
      }
      normal.b[row] += weight * (constants[c] * p(i, effort) - p(i, known));
    }
  }
  return normal;
}

RobotSearch::RobotSearch(const RobotRows& rows, const RobotGround& ground, std::vector<RobotHypothesis> hypotheses)
    : rows_(rows), ground_(ground), hypotheses_(std::move(hypotheses)) {
  addOrdinary();
  shapes_.resize(hypotheses_.size());
  base_ = std::ssize(ground.base.columns);
  for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
    const RobotHypothesis& own = hypotheses_[h];
    shapes_[h].at = own.start.size() > 0 ? own.start : VectorXd(VectorXd::Zero(std::ssize(own.parameters)));
    if (!hypotheses_[h].torque) continue;
    shapes_[h].first_extra = std::ssize(extras_);
    extras_.resize(extras_.size() + hypotheses_[h].parameters.size() + (hypotheses_[h].linear ? 0 : 1));
  }
  all_ = base_ + std::ssize(extras_);
  tbb::parallel_for(std::size_t{0}, hypotheses_.size(), [&](std::size_t h) { shape(h); });
  stopIfInterrupted();
  sum();
  const std::vector<JointSums> total = sums_.total(ground_.training);
  tbb::parallel_for(std::size_t{0}, hypotheses_.size(), [&](std::size_t h) { findActive(h, total); });
  for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
    if (hypotheses_[h].ordinary || hypotheses_[h].drive < 0 || shapes_[h].active.empty()) continue;
    const std::size_t other = hypotheses_.size() - rows_.joints() + static_cast<std::size_t>(hypotheses_[h].drive);
    if (shapes_[other].testable && !contains(other, h)) shapes_[h].beside = other;
  }
}

void RobotSearch::addOrdinary() {
  const RobotRegressor& regressor = rows_.regressor();
  const Index own = 1 + std::ssize(regressor.law().terms);
  for (std::size_t c = 0; c < rows_.joints(); ++c) {
    RobotHypothesis h;
    h.cause = "drive";
    h.target = rows_.jointName(c);
    h.ordinary = true;
    h.drive = static_cast<int>(c);
    for (Index k = 0; k <= own; ++k) h.parameters.push_back({{"number", "1"}});
    h.change = [&regressor, c, own](const VectorXd& theta) {
      VectorXd change = VectorXd::Zero(regressor.columns());
      change.segment(regressor.offsetColumn(c), own) = theta.head(own);
      change[regressor.rotorColumn(c)] = theta[own];
      return change;
    };
    hypotheses_.push_back(std::move(h));
  }
}

RobotSearch::Set RobotSearch::beside(std::size_t h) const {
  return shapes_[h].beside ? Set{*shapes_[h].beside} : Set{};
}

RobotSearch::Set RobotSearch::expanded(const Set& set) const {
  Set all = set;
  for (const std::size_t h : set) {
    for (const std::size_t other : beside(h)) {
      if (std::ranges::find(all, other) == all.end()) all.push_back(other);
    }
  }
  return all;
}

/// Columns and what stands beside them where the hypothesis is now: f(theta) = f(at) + slopes (theta - at).
void RobotSearch::shape(std::size_t h) {
  if (interruptRequested()) return;
  const RobotHypothesis& hypothesis = hypotheses_[h];
  Shape& s = shapes_[h];
  const Index count = std::ssize(hypothesis.parameters);
  s.columns = MatrixXd::Zero(all_, count);
  s.known = VectorXd::Zero(all_);
  const auto moved = [&](Index k, double by) {
    VectorXd theta = hypothesis.linear ? VectorXd(VectorXd::Zero(count)) : s.at;
    theta[k] += by;
    return theta;
  };
  const auto step = [&](Index k) { return hypothesis.parameters[k].step; };
  if (hypothesis.change) {
    const auto base = [&](const VectorXd& theta) {
      return VectorXd(ground_.base.combination * hypothesis.change(theta));
    };
    for (Index k = 0; k < count; ++k) {
      s.columns.col(k).head(base_) = (base(moved(k, step(k))) - base(moved(k, -step(k)))) / (2.0 * step(k));
    }
    if (!hypothesis.linear) s.known.head(base_) = base(s.at) - s.columns.topRows(base_) * s.at;
    return;
  }
  const auto extra = [&](Index k) -> ExtraColumn& { return extras_[s.first_extra + k]; };
  for (Index k = 0; k < count; ++k) {
    s.columns(base_ + s.first_extra + k, k) = 1.0;
    if (hypothesis.linear) {
      extra(k) = hypothesis.torque(moved(k, 1.0));
      continue;
    }
    const double scale = 0.5 / step(k);
    extra(k) =
        sumOf(times(scale, hypothesis.torque(moved(k, step(k)))), times(-scale, hypothesis.torque(moved(k, -step(k)))));
  }
  if (hypothesis.linear) return;
  extra(count) = ExtraColumn(rows_.joints());
  if (s.at.isZero()) return;
  s.known[base_ + s.first_extra + count] = 1.0;
  extra(count) = hypothesis.torque(s.at);
  for (Index k = 0; k < count; ++k) extra(count) = sumOf(std::move(extra(count)), times(-s.at[k], extra(k)));
}

void RobotSearch::sum() {
  const std::vector<bool> every(rows_.log().blocks.size(), true);
  sums_ = sumDynamics(rows_.log(), rows_.regressor(), ground_.base, rows_.model().curves, every, extras_);
  acts_.clear();
  for (std::size_t c = 0; c < rows_.joints(); ++c) {
    std::vector<std::size_t>& acts = acts_.emplace_back(ground_.base.acts[c]);
    for (std::size_t e = 0; e < extras_.size(); ++e) {
      if (extras_[e][c].size() > 0) acts.push_back(static_cast<std::size_t>(base_) + e);
    }
  }
  std::vector<double> variance = ground_.variance;
  for (double& v : variance) v *= ground_.inflation;
  blocks_.assign(sums_.blocks.size(), {});
  counted_ = BlockErrors::Zero(std::ssize(sums_.blocks), std::ssize(acts_));
  tbb::parallel_for(std::size_t{0}, sums_.blocks.size(), [&](std::size_t b) {
    blocks_[b] = normalOf(sums_.blocks[b], acts_, all_, variance, ground_.constants);
    for (std::size_t c = 0; c < acts_.size(); ++c) {
      counted_(static_cast<Index>(b), static_cast<Index>(c)) = sums_.blocks[b][c].rows;
    }
  });
  without_.assign(kRobotFolds + 1, {MatrixXd::Zero(all_, all_), VectorXd::Zero(all_)});
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (!ground_.training[b]) continue;
    for (int f = 0; f <= kRobotFolds; ++f) {
      if (ground_.fold[b] != f) without_[f] += blocks_[b];
    }
  }
}

void RobotSearch::findActive(std::size_t h, const std::vector<JointSums>& total) {
  Shape& s = shapes_[h];
  const RobotNormal& all = without_.back();
  const MatrixXd cross = all.a * s.columns, gram = s.columns.transpose() * cross;
  // Gram and Schmidt in the metric of the log, in the parameters' order.
  const Index count = s.columns.cols();
  MatrixXd left = s.columns;
  for (Index k = 0; k < count; ++k) {
    for (const Index j : s.active) {
      const double length = left.col(j).dot(all.a * left.col(j));
      left.col(k) -= left.col(j) * (left.col(j).dot(all.a * left.col(k)) / length);
    }
    const double own = left.col(k).dot(all.a * left.col(k));
    if (gram(k, k) > 0.0 && own > kSame * gram(k, k)) s.active.push_back(k);
  }
  const MatrixXd base = all.a.topLeftCorner(base_, base_) + ground_.precision;
  const MatrixXd onto = cross.topRows(base_);
  const MatrixXd rest = gram - onto.transpose() * base.ldlt().solve(onto);
  s.testable = std::ranges::any_of(s.active, [&](Index k) { return rest(k, k) > kAbsorbed * gram(k, k); });
  // Joints that feel it, each column at its own length.
  VectorXd weight = VectorXd::Zero(std::ssize(acts_));
  for (std::size_t c = 0; c < acts_.size(); ++c) {
    const MatrixXd columns = s.columns(acts_[c], Eigen::all);
    const MatrixXd& products = total[c].products;
    const MatrixXd squares = columns.transpose() * products.topLeftCorner(columns.rows(), columns.rows()) * columns;
    for (const Index k : s.active) weight[c] += squares(k, k) / ground_.variance[c] / gram(k, k);
  }
  for (std::size_t c = 0; c < acts_.size(); ++c) {
    if (weight[c] > kActs * weight.sum()) s.joints.push_back(c);
  }
}

MatrixXd RobotSearch::activeColumns(std::size_t h) const { return shapes_[h].columns(Eigen::all, shapes_[h].active); }

bool RobotSearch::contains(std::size_t g, std::size_t h) const {
  const MatrixXd& a = without_.back().a;
  const MatrixXd of_g = activeColumns(g), of_h = activeColumns(h);
  const MatrixXd gram = of_g.transpose() * a * of_g, cross = of_g.transpose() * a * of_h;
  const VectorXd own = (of_h.transpose() * a * of_h).diagonal();
  const VectorXd left = own - (cross.transpose() * gram.ldlt().solve(cross)).diagonal();
  return (left.array() <= kSame * own.array()).all();
}

BlockErrors RobotSearch::errors(const VectorXd& z, const std::vector<bool>& blocks) const {
  BlockErrors errors = BlockErrors::Zero(counted_.rows(), counted_.cols());
  std::vector<Index> used;  // most extra columns are not
  VectorXd v;
  for (std::size_t c = 0; c < acts_.size(); ++c) {
    const Index known = std::ssize(acts_[c]);
    used.clear();
    v.resize(known + 2);
    v << -z(acts_[c]), -1.0, ground_.constants[c];
    for (Index i = 0; i < v.size(); ++i) {
      if (v[i] != 0.0) used.push_back(i);
    }
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (!blocks[b]) continue;
      const MatrixXd& p = sums_.blocks[b][c].products;
      double sum = 0.0;
      for (const Index k : used) {
        double row = 0.5 * p(k, k) * v[k];
        for (const Index i : used) {
          if (i >= k) break;
          row += p(i, k) * v[i];
        }
        sum += 2.0 * v[k] * row;
      }
      errors(static_cast<Index>(b), static_cast<Index>(c)) = std::max(0.0, sum) / ground_.variance[c];
    }
  }
  return errors;
}

BlockErrors RobotSearch::validate(const Set& set, bool without_prior) const {
  BlockErrors all = BlockErrors::Zero(counted_.rows(), counted_.cols());
  std::vector<bool> own(blocks_.size());
  for (int f = 0; f < kRobotFolds; ++f) {
    for (std::size_t b = 0; b < own.size(); ++b) own[b] = ground_.training[b] && ground_.fold[b] == f;
    all += errors(fit(set, f, without_prior).z, own);
  }
  return all;
}

VectorXd RobotSearch::clamped(std::size_t h, VectorXd theta) const {
  for (std::size_t k = 0; k < hypotheses_[h].parameters.size(); ++k) {
    const RobotCauseParameter& parameter = hypotheses_[h].parameters[k];
    double& value = theta[k];
    value = std::clamp(value, parameter.lower, parameter.upper);
  }
  return theta;
}

bool RobotSearch::moveTo(std::size_t h, const VectorXd& theta) {
  constexpr double kLittle = 0.02, kLittleOfStep = 0.1;
  const VectorXd now = clamped(h, theta);
  bool far = false;
  for (Index k = 0; k < now.size(); ++k) {
    const double moved = std::abs(now[k] - shapes_[h].at[k]);
    far = far || moved > std::max(kLittle * std::abs(now[k]), kLittleOfStep * hypotheses_[h].parameters[k].step);
  }
  if (far) shapes_[h].at = now;
  return far;
}

bool RobotSearch::relinearise() {
  const double before = fit({}, kRobotFolds).cost;
  std::vector<std::size_t> moving;
  for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
    if (hypotheses_[h].linear || !shapes_[h].testable) continue;
    const Fit own = fit({h}, kRobotFolds);
    constexpr double kPromising = 2e-4;  // of the rows' weighed squares
    if (before - own.cost < kPromising * counted_.sum() / ground_.inflation) continue;
    if (moveTo(h, own.theta.front())) moving.push_back(h);
  }
  tbb::parallel_for(std::size_t{0}, moving.size(), [&](std::size_t k) { shape(moving[k]); });
  stopIfInterrupted();
  const bool extras = std::ranges::any_of(moving, [&](std::size_t h) { return bool{hypotheses_[h].torque}; });
  if (extras) sum();
  return !moving.empty();
}

bool RobotSearch::settle(const Set& set) {
  constexpr int kRounds = 5;
  bool moved = false;
  for (int round = 0; round < kRounds; ++round) {
    const Fit all = fit(set, kRobotFolds);
    bool moves = false, extras = false;
    for (std::size_t k = 0; k < set.size(); ++k) {
      if (hypotheses_[set[k]].linear || !moveTo(set[k], all.theta[k])) continue;
      shape(set[k]);
      moves = true;
      extras = extras || hypotheses_[set[k]].torque;
    }
    if (extras) sum();
    if (!moves) break;
    moved = true;
  }
  return moved;
}

RobotSearch::Set without(const RobotSearch::Set& set, std::size_t cause) {
  RobotSearch::Set rest = set;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(cause));
  return rest;
}

RobotSearch::Set bareOf(const RobotSearch& search, const RobotSearch::Set& set, std::size_t cause) {
  RobotSearch::Set rest = without(set, cause);
  for (const std::size_t other : search.beside(set[cause])) rest.push_back(other);
  return rest;
}

GroupErrors groupErrors(const BlockErrors& errors, const BlockErrors& counted, const std::vector<bool>& blocks,
                        const std::vector<std::size_t>& joints) {
  std::vector<double> sums, rows;
  for (Index b = 0; b < errors.rows(); ++b) {
    if (!blocks[b]) continue;
    double sum = 0.0, count = 0.0;
    for (const std::size_t c : joints) {
      sum += errors(b, static_cast<Index>(c));
      count += counted(b, static_cast<Index>(c));
    }
    if (count == 0.0) continue;
    sums.push_back(sum);
    rows.push_back(count);
  }
  const auto toArray = [](const std::vector<double>& values) -> Eigen::ArrayXd {
    return Eigen::Map<const Eigen::ArrayXd>(values.data(), std::ssize(values));
  };
  return {toArray(sums), toArray(rows)};
}

}  // namespace simgap
