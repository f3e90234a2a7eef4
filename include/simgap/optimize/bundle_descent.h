/// \file
/// Descent of a function with kinks, to where a smooth method sticks: a line that is about to become slack bends the
/// slope of a misfit, and behind the bend a Gauss-Newton step sees a cost that is not there, or none that is.
///
/// The function is modelled from above its tangents at points x_k passed so far,
///
///   m(d) = max_k (f(x) - e_k + g_k^T d) + 1/2 d^T N d,    e_k = f(x) - f(x_k) - g_k^T (x - x_k) >= 0
///
/// whose minimum is d = -N^-1 sum_k l_k g_k with the weights l on the simplex that minimise
/// 1/2 l^T G^T N^-1 G l + e^T l. A step that falls short of the model's promise adds its tangent instead.
/// Source: Lemaréchal and Sagastizábal, "Variable metric bundle methods: from conceptual to implementable forms", 1997,
/// section 2.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace simgap {

struct KinkedFunction {
  std::function<double(const Eigen::VectorXd& x)> value;  ///< infinite where there is none
  /// Curvature N (positive definite) and slope g on the side of x, shapes (n, n) and (n).
  std::function<void(const Eigen::VectorXd& x, Eigen::MatrixXd& curvature, Eigen::VectorXd& slope)> linearise;
  Eigen::VectorXd lower, upper;  ///< bounds, may be infinite, shape (n)
};

struct BundleDescent {
  Eigen::VectorXd x;
  double value = 0.0;
  Eigen::MatrixXd curvature;  ///< N at x
  int steps = 0;
};

/// From x to the next local minimum. \param enough  ends where the model promises less than that
BundleDescent descendBundle(const KinkedFunction& function, const Eigen::VectorXd& x, double enough,
                            int max_steps = 100);

}  // namespace simgap
