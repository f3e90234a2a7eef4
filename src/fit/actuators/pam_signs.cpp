#include "pam_signs.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <vector>

#include "opposite_sign.h"

namespace simgap {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;

/// Normal matrix of [p eps^2, -p eps, p, 1, f].
Eigen::MatrixXd muscleProducts(const PamLog& log) {
  const auto terms = [](double p, double eps) { return Eigen::Vector3d(p * eps * eps, -p * eps, p); };
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(5, 5);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    Eigen::Vector3d muscle = terms(log.pressure[i], log.contraction[i]);
    if (log.opposed()) muscle -= terms(log.opposing_pressure[i], log.opposing_contraction[i]);
    Vector5 row;
    row << muscle, 1.0, log.force[i];
    sums.noalias() += row * row.transpose();
  }
  return sums;
}

}  // namespace

std::string oppositePamSign(const PamLog& log) {
  const Eigen::MatrixXd sums = muscleProducts(log);
  std::vector<LinearTerm> terms(4);
  terms.back().lower = -std::numeric_limits<double>::infinity();
  const auto rmsWith = [&](double of_contraction, double of_force) {
    Vector5 signs = Vector5::Ones();
    signs[1] = of_contraction, signs[4] = of_force;
    return std::sqrt(std::max(costTurned(sums, signs, terms), 0.0) / static_cast<double>(log.rows()));
  };
  const double as_it_is = rmsWith(1.0, 1.0), turned_force = rmsWith(1.0, -1.0);
  const double turned_contraction = log.of_joint ? turned_force : rmsWith(-1.0, 1.0);
  const bool of_force = turned_force <= turned_contraction;
  const double turned = of_force ? turned_force : turned_contraction;
  if (!(turned * turned < kOtherSign * as_it_is * as_it_is)) return {};
  const std::string channel = of_force ? log.force_column : "contraction";
  return fmt::format(
      "{} has the opposite sign: turned round, a muscle explains the force to {:.3g} N, as it is to {:.3g}; {}",
      channel, turned, as_it_is, turnItRound(channel));
}

}  // namespace simgap
