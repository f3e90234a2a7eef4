#include "drawn_mass.h"

#include <Eigen/Cholesky>

namespace simgap {

Eigen::VectorXd drawnMobility(const std::vector<DrawnBody>& bodies, const std::vector<DrawnDof>& dofs) {
  const auto count = static_cast<Eigen::Index>(dofs.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
  std::vector<std::vector<Eigen::Index>> moving(bodies.size());  // what moves a body
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].parent >= 0) moving[b] = moving[bodies[b].parent];
    for (Eigen::Index d = 0; d < count; ++d) {
      if (dofs[d].body == b) moving[b].push_back(d);
    }
    const MassProperties& mass = bodies[b].mass;
    Eigen::Matrix3Xd way(3, std::ssize(moving[b])), turn(3, std::ssize(moving[b]));  // velocities per dof
    for (Eigen::Index i = 0; i < way.cols(); ++i) {
      const DrawnDof& dof = dofs[static_cast<std::size_t>(moving[b][i])];
      turn.col(i) = dof.slides ? Eigen::Vector3d::Zero() : dof.axis;
      way.col(i) = dof.slides ? dof.axis : Eigen::Vector3d(dof.axis.cross(mass.centre_of_mass - dof.point));
    }
    matrix(moving[b], moving[b]) += mass.mass * way.transpose() * way + turn.transpose() * mass.inertia * turn;
  }
  for (Eigen::Index d = 0; d < count; ++d) matrix(d, d) += dofs[d].armature;
  return matrix.ldlt().solve(Eigen::MatrixXd::Identity(count, count)).diagonal();
}

}  // namespace simgap
