#include "simgap/core/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace simgap {

using Eigen::MatrixXd;

SymmetricEigen symmetricEigen(const MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetricEigenvalues(const MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

RightSingular rightSingular(const MatrixXd& matrix) {
  const Eigen::BDCSVD<MatrixXd> svd(matrix, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::VectorXd singularValues(const MatrixXd& matrix) { return Eigen::BDCSVD<MatrixXd>(matrix).singularValues(); }

MatrixXd solveLeastSquares(const MatrixXd& a, const MatrixXd& b) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(a).solve(b);
}

MatrixXd inverse(const MatrixXd& matrix) { return matrix.inverse(); }

}  // namespace simgap
