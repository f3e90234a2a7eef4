// What models leave of a log, on pieces of its blocks.
#include <algorithm>
#include <cmath>

#include "log_hypotheses.h"

namespace simgap {

using Eigen::Index;

double rowsIn(const std::vector<Block>& blocks, const std::vector<bool>& keep) {
  double rows = 0.0;
  for (const Block& b : blocks) {
    rows += static_cast<double>(std::count(keep.begin() + static_cast<std::ptrdiff_t>(b.begin),
                                           keep.begin() + static_cast<std::ptrdiff_t>(b.end), true));
  }
  return rows;
}

Eigen::VectorXd residualOf(const Fitted& fitted) { return residualOf(fitted, fitted.theta); }

Eigen::VectorXd residualOf(const Fitted& fitted, std::span<const double> theta) {
  Eigen::VectorXd residual;
  fitted.model->evaluate(theta, residual, nullptr);
  return residual;
}

std::vector<Block> LogSearch::pieces(const std::vector<Block>& blocks, double seconds) const {
  const auto rows = static_cast<std::size_t>(std::max(8.0, std::round(seconds / data_.rows.step)));
  std::vector<Block> pieces;
  for (const Block& b : blocks) {
    const std::size_t count = std::max<std::size_t>(1, (b.size() + rows / 2) / rows);
    for (std::size_t k = 0; k < count; ++k) {
      const Block piece{b.begin + b.size() * k / count, b.begin + b.size() * (k + 1) / count};
      if (rowsIn({piece}, data_.keep) > 0.0) pieces.push_back(piece);
    }
  }
  return pieces;
}

GroupErrors LogSearch::errors(const Fitted& fitted, const std::vector<Block>& blocks, double piece_seconds) const {
  return errors(residualOf(fitted), blocks, piece_seconds);
}

GroupErrors LogSearch::errors(const Eigen::VectorXd& residual, const std::vector<Block>& blocks,
                              double piece_seconds) const {
  const std::vector<Block> parts = pieces(blocks, piece_seconds);
  GroupErrors errors{Eigen::ArrayXd(static_cast<Index>(parts.size())),
                     Eigen::ArrayXd(static_cast<Index>(parts.size()))};
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto part = residual.segment(parts[k].begin, parts[k].size());
    const double rows = rowsIn({parts[k]}, data_.keep);
    // A delay moves the rows that do not count: the mean is compared, over the rows that every model has.
    const auto counted = static_cast<double>((part.array() != 0.0).count());
    errors.sum[k] = part.squaredNorm() * rows / std::max(counted, 1.0);
    errors.rows[k] = rows;
  }
  return errors;
}

Nested LogSearch::added(const Eigen::VectorXd& rest, const Eigen::VectorXd& full, const std::vector<Block>& blocks,
                        double piece_seconds) const {
  const Eigen::ArrayXd both = (rest.array() != 0.0 && full.array() != 0.0).cast<double>();
  const Eigen::VectorXd more = (both * (rest - full).array()).matrix();
  const std::vector<Block> parts = pieces(blocks, piece_seconds);
  const auto count = static_cast<Index>(parts.size());
  Nested nested{Eigen::ArrayXd(count), Eigen::ArrayXd(count)};
  for (Index k = 0; k < count; ++k) {
    const Block& part = parts[k];
    const auto begin = static_cast<Index>(part.begin), size = static_cast<Index>(part.size());
    nested.products[k] = rest.segment(begin, size).dot(more.segment(begin, size));
    nested.squares[k] = more.segment(begin, size).squaredNorm();
  }
  return nested;
}

}  // namespace simgap
