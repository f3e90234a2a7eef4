/// \file
/// Friction of guides within a step. Line i slips at s_i = J_i v; its guide answers with an impulse of at most m_i
/// against the slip that it leaves, m_i s_i / sqrt(s_i^2 + c_i^2), c_i being the speed at which a line that is said to
/// stick still gives way:
///
///     A (v - v_0) + sum_i J_i^T m_i s_i / sqrt(s_i^2 + c_i^2) = 0
///
/// That is where the gradient of a strictly convex function vanishes,
///
///     f(v) = 1/2 (v - v_0)^T A (v - v_0) + sum_i m_i sqrt(s_i^2 + c_i^2),
///
/// whose minimum Newton's steps find: each goes along its direction to where f is least.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace simgap {

/// Memory is taken when it is made only.
class GuideSlip {
 public:
  GuideSlip(Eigen::Index degrees_of_freedom, std::size_t lines);

  void clear() { used_ = 0; }
  /// A line of this step. \param row  J_i, shape (dof) [m/rad]  \param most  m_i > 0 [N s]  \param creep  c_i > 0 [m/s]
  void add(const Eigen::VectorXd& row, double most, double creep);
  bool empty() const { return used_ == 0; }
  /// \param inertia  A, shape (dof, dof)  \param near  where to begin, shape (dof)
  /// \param[in,out] v  v_0, and what friction leaves of it  \returns Newton's steps
  int solve(const Eigen::MatrixXd& inertia, const Eigen::VectorXd& near, Eigen::VectorXd& v);
  /// How velocities answer to further impulses beside the guides, a line that creeps holding the bodies: inverse of
  /// A + sum_i J_i^T m_i c_i^2 / (s_i^2 + c_i^2)^1.5 J_i at what solve() has found, shape (dof, dof)
  const Eigen::MatrixXd& mobility() const { return mobility_; }

 private:
  struct Line {
    Eigen::VectorXd row;
    double most, creep;
    double slip, by_step;  ///< where the search is, and how a step changes it
  };
  double slopeAlong(double part) const;
  double leastAlong() const;

  std::vector<Line> lines_;
  std::size_t used_ = 0;
  Eigen::MatrixXd mobility_;
  Eigen::VectorXd at_, step_, downhill_, push_;
  double slope_of_bodies_ = 0.0, bend_of_bodies_ = 0.0;  ///< of the first term along a step
};

}  // namespace simgap
