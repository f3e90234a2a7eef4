/// \file
/// For the steps of motions, which take no memory.
#pragma once

#include <Eigen/Core>

namespace simgap {

/// A symmetric positive definite matrix becomes its inverse, by sweeps (Goodnight 1979). Small, without memory of its
/// own.
inline void invertInPlace(Eigen::MatrixXd& a) {
  const Eigen::Index n = a.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    const double pivot = 1.0 / a(k, k);
    a(k, k) = pivot;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a(i, k) * pivot;
      for (Eigen::Index j = 0; j < n; ++j) {
        if (j != k) a(i, j) -= factor * a(k, j);
      }
      a(i, k) = -factor;
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      if (j != k) a(k, j) *= pivot;
    }
  }
}

}  // namespace simgap
