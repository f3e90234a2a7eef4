/// \file
/// The sums a separable fit with a Stribeck term needs. A column is x, x (1 - E) or x E, and E depends on a row's speed
/// alone: rows of nearly the same speed are summed up once (bins of log |w|), after which the normal matrix at any
/// (v_s, delta) costs microseconds instead of a pass over the log. 1 - E is summed as such, so that nothing cancels
/// where it is small.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "simgap/model/friction/friction_law.h"

namespace simgap {

class StribeckMoments {
 public:
  /// Bins 1.4 % wide, wherever the rows may lie.
  /// \param shapes  of the columns of X and, last, the target (always).  \param top  largest log speed.
  StribeckMoments(std::vector<FrictionShape> shapes, double top);
  /// Bins for these rows only. A log of few rows gets narrow ones, most of which hold one row and are then exact.
  /// \param log_speed  shape (n): of all rows that will be added.
  StribeckMoments(std::vector<FrictionShape> shapes, const Eigen::ArrayXd& log_speed);

  /// Adds rows. \param log_speed  shape (n).  \param x  shape (n, C + 1): columns without their shapes.
  void add(const Eigen::Ref<const Eigen::ArrayXd>& log_speed, const Eigen::Ref<const Eigen::ArrayXXd>& x);
  /// Adds or takes away the rows of other sums with the same bins.
  void add(const StribeckMoments& other, double sign);

  /// The normal matrix of [X y], shape (C + 1, C + 1).
  Eigen::MatrixXd gram(double v_s, double delta) const;

 private:
  /// Which function of E a product of two columns is multiplied by.
  enum Weight { kSliding, kStatic, kSlidingSliding, kSlidingStatic, kStaticStatic, kWeights };
  struct Product {
    Eigen::Index a, b;  ///< columns
  };

  StribeckMoments(std::vector<FrictionShape> shapes, double top, Eigen::Index cells);
  Eigen::Index cellOf(double log_speed) const;
  void makeBins(Eigen::Index bins);

  std::vector<FrictionShape> shapes_;             ///< shape (C + 1)
  std::vector<Product> products_;                 ///< with a shaped column, by weight: M of them
  std::array<Eigen::Index, kWeights + 1> first_;  ///< of the products of each weight
  double top_;
  Eigen::Index cells_;                                            ///< of equal width in log speed
  std::shared_ptr<const std::vector<Eigen::Index>> bin_of_cell_;  ///< null: every cell is a bin
  Eigen::MatrixXd always_;           ///< shape (C + 1, C + 1): sums over all rows, meant for the unshaped columns
  Eigen::VectorXd count_, sum_log_;  ///< shape (bins)
  Eigen::MatrixXd mixed_;            ///< shape (bins, M): sums of the products
};

}  // namespace simgap
