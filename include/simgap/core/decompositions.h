/// \file
/// Eigen's decompositions of matrices of any size, compiled once: each takes a compiler many seconds, more than the
/// code that asks for it.
#pragma once

#include <Eigen/Core>

namespace simgap {

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< shape (n), ascending
  Eigen::MatrixXd vectors;  ///< shape (n, n), in columns
};
/// Of a symmetric matrix, shape (n, n); its lower triangle is read.
SymmetricEigen symmetricEigen(const Eigen::MatrixXd& matrix);

/// Its values alone, which take a quarter of the time.
Eigen::VectorXd symmetricEigenvalues(const Eigen::MatrixXd& matrix);

struct RightSingular {
  Eigen::VectorXd values;   ///< shape (min(m, n)), descending
  Eigen::MatrixXd vectors;  ///< shape (n, n): V of A = U S V^T, in columns; those beyond `values` span the null space
};
/// \param matrix  A, shape (m, n)
RightSingular rightSingular(const Eigen::MatrixXd& matrix);
/// Of a matrix of shape (m, n): shape (min(m, n)), descending.
Eigen::VectorXd singularValues(const Eigen::MatrixXd& matrix);

/// The X of least |A X - B|. \param a  shape (m, n), m >= n  \param b  shape (m, k)
Eigen::MatrixXd solveLeastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of a regular matrix, shape (n, n).
Eigen::MatrixXd inverse(const Eigen::MatrixXd& matrix);

}  // namespace simgap
