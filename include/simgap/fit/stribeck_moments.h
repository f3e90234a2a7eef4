/// \file
/// The sums a separable fit with a Stribeck term needs. A column is x, x (1 - E) or x E, and E depends on a row's speed
/// alone: rows of nearly the same speed are summed up once (bins of log |w|, 1.4 % wide), after which the normal matrix
/// at any (v_s, delta) costs microseconds instead of a pass over the log. 1 - E is summed as such, so that nothing
/// cancels where it is small.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "simgap/model/friction_law.h"

namespace simgap {

class StribeckMoments {
 public:
  /// \param shapes  of the columns of X and, last, the target (always).  \param top  largest log speed.
  StribeckMoments(std::vector<FrictionShape> shapes, double top);

  /// Adds rows. \param log_speed  shape (n).  \param x  shape (n, C + 1): columns without their shapes.
  void add(const Eigen::Ref<const Eigen::ArrayXd>& log_speed, const Eigen::Ref<const Eigen::ArrayXXd>& x);
  /// Adds or takes away the rows of other sums of the same shape.
  void add(const StribeckMoments& other, double sign);

  /// The normal matrix of [X y], shape (C + 1, C + 1).
  Eigen::MatrixXd gram(double v_s, double delta) const;

 private:
  std::vector<FrictionShape> shapes_;  ///< shape (C + 1)
  std::vector<Eigen::Index> shaped_;   ///< columns whose shape is not `always`: S of them
  double top_;
  Eigen::MatrixXd always_;           ///< shape (C + 1, C + 1): sums over all rows, meant for the unshaped columns
  Eigen::VectorXd count_, sum_log_;  ///< shape (bins)
  Eigen::MatrixXd mixed_;            ///< shape ((C + 1) S, bins): sums of x_i x_shaped
};

}  // namespace simgap
