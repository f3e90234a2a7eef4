/// \file
/// What a regression whose coefficients cannot be negative says about the signs of its columns.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "simgap/optimize/separable.h"

namespace simgap {

/// Of the squared error: what a channel turned round may leave at most to have been recorded with the opposite sign.
inline constexpr double kOtherSign = 0.5;

/// Whether rows go both ways, a twentieth of them the rarer one. Of motion in one direction alone friction that falls
/// with speed, or a law of another shape, looks like a velocity turned round.
inline bool goesBothWays(const Eigen::Ref<const Eigen::ArrayXd>& direction) {
  const auto forth = (direction > 0.0).count(), back = (direction < 0.0).count();
  return 20 * std::min(forth, back) >= forth + back && back > 0;
}

/// The squared error of min |y - X c|^2 within the terms' bounds when each column of [X y] is multiplied by its sign.
/// \param gram  normal matrix of [X y], shape (C + 1, C + 1). \param signs  1 or -1 each, shape (C + 1)
inline double costTurned(const Eigen::MatrixXd& gram, const Eigen::VectorXd& signs, std::span<const LinearTerm> terms) {
  return solveBounded(signs.asDiagonal() * gram * signs.asDiagonal(), terms).cost;
}

/// How to mend it. \param channel  as simgap calls it; the file may have it in another unit
inline std::string turnItRound(std::string_view channel) {
  return fmt::format("turn it with --map {}=COLUMN*-1, with the unit of COLUMN in the name", channel);
}

}  // namespace simgap
