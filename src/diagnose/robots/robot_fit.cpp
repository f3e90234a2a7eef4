// What a set of hypotheses comes to on the sums of a log, and how surely.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "robot_search.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A symmetric system in units of its diagonal. A way that nothing determines is not gone: it is held where it stands.
class HeldSystem {
 public:
  explicit HeldSystem(const MatrixXd& a)
      : scale_(a.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; })) {
    constexpr double kHeld = 1e-10;
    MatrixXd scaled = scaledBy(a);
    scaled.diagonal().array() += kHeld;
    factor_.compute(scaled);
  }
  VectorXd solve(const VectorXd& b) const { return scale_.cwiseProduct(factor_.solve(scale_.cwiseProduct(b))); }
  /// A^-1 M A^-1 of a symmetric M.
  MatrixXd between(const MatrixXd& m) const {
    const MatrixXd half = factor_.solve(scaledBy(m));
    return scaledBy(factor_.solve(half.transpose()));
  }

 private:
  MatrixXd scaledBy(const MatrixXd& m) const { return scale_.asDiagonal() * m * scale_.asDiagonal(); }

  VectorXd scale_;
  Eigen::LDLT<MatrixXd> factor_;
};

}  // namespace

/// Columns of all that a set adds, shape (D, active numbers), in its order.
MatrixXd RobotSearch::waysOf(const Set& set) const {
  Index count = 0;
  for (const std::size_t h : set) count += std::ssize(shapes_[h].active);
  MatrixXd ways(all_, count);
  Index at = 0;
  for (const std::size_t h : set) {
    const MatrixXd columns = activeColumns(h);
    ways.middleCols(at, columns.cols()) = columns;
    at += columns.cols();
  }
  return ways;
}

RobotSearch::Fit RobotSearch::fit(const Set& named, int left_out, bool without_prior) const {
  const Set set = expanded(named);
  const RobotNormal& normal = without_[left_out];
  // Ways to go from where it stands: every base parameter, and the hypotheses' own.
  const MatrixXd ways = waysOf(set);
  VectorXd start = VectorXd::Zero(all_);
  start.head(base_) = ground_.x0;
  for (const std::size_t h : set) start += shapes_[h].known;
  const Index own = ways.cols();
  const MatrixXd cross = normal.a * ways;
  MatrixXd a(base_ + own, base_ + own);
  a.topLeftCorner(base_, base_) = normal.a.topLeftCorner(base_, base_);
  if (!without_prior) a.topLeftCorner(base_, base_) += ground_.precision;
  a.topRightCorner(base_, own) = cross.topRows(base_);
  a.bottomLeftCorner(own, base_) = cross.topRows(base_).transpose();
  a.bottomRightCorner(own, own) = ways.transpose() * cross;
  const VectorXd score = normal.b - normal.a * start;
  VectorXd b(base_ + own);
  b << score.head(base_), ways.transpose() * score;
  const VectorXd move = HeldSystem(a).solve(b), moved = move.head(base_);
  Fit fit;
  fit.z = start + ways * move.tail(own);
  fit.z.head(base_) += moved;
  fit.cost = fit.z.dot(normal.a * fit.z) - 2.0 * normal.b.dot(fit.z);
  if (!without_prior) fit.cost += moved.dot(ground_.precision * moved);
  Index at = base_;
  for (const std::size_t h : set) {
    VectorXd& theta = fit.theta.emplace_back(VectorXd::Zero(shapes_[h].columns.cols()));
    for (const Index k : shapes_[h].active) theta[k] = move[at++];
  }
  fit.theta.resize(named.size());
  return fit;
}

MatrixXd RobotSearch::covariance(const Set& named, const Fit& fit) const {
  const Set set = expanded(named);
  const MatrixXd own = waysOf(set);
  MatrixXd ways = MatrixXd::Zero(all_, base_ + own.cols());
  ways.topLeftCorner(base_, base_).setIdentity();
  ways.rightCols(own.cols()) = own;
  MatrixXd a = ways.transpose() * without_.back().a * ways;
  a.topLeftCorner(base_, base_) += ground_.precision;
  // The sandwich: what the scores of blocks scatter by, between two inverses.
  MatrixXd meat = MatrixXd::Zero(a.rows(), a.cols());
  double blocks = 0.0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    if (!ground_.training[b]) continue;
    const VectorXd score = ways.transpose() * (blocks_[b].b - blocks_[b].a * fit.z);
    meat += score * score.transpose();
    ++blocks;
  }
  meat *= blocks / std::max(1.0, blocks - 1.0);
  meat.topLeftCorner(base_, base_) += ground_.precision;
  const MatrixXd whole = HeldSystem(a).between(meat);
  // Numbers that are not active have none.
  std::vector<Index> places;
  Index all = 0, asked = 0;
  for (std::size_t k = 0; k < set.size(); ++k) {
    for (const Index number : shapes_[set[k]].active) places.push_back(all + number);
    all += shapes_[set[k]].columns.cols();
    if (k + 1 == named.size()) asked = all;
  }
  MatrixXd result = MatrixXd::Zero(all, all);
  result(places, places) = whole.bottomRightCorner(own.cols(), own.cols());
  return result.topLeftCorner(asked, asked);
}

}  // namespace simgap
