/// \file
/// Squared errors of two models on the same pieces of a log, compared piece by piece.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Sums of squared errors over short pieces of a log, shape (pieces), and the rows in each.
struct PieceErrors {
  Eigen::ArrayXd sum;
  Eigen::ArrayXd rows;
  double mse() const { return sum.sum() / rows.sum(); }
};

/// How much lower the error of `after` is than that of `before`, as a fraction, with a 95 % interval from a bootstrap
/// of runs of neighbouring pieces (moving blocks: Kunsch 1989). A pure function of its arguments.
Interval pairedGain(const PieceErrors& before, const PieceErrors& after, std::uint64_t seed);

/// One-sided p-value of "after is no better than before", the correlation of neighbouring pieces (AR(1)) counted: the
/// smallest of three tests, times three. The mean difference is what the error is made of, but a few pieces under large
/// loads rule it; the mean log ratio counts every piece alike; signed ranks find what only some pieces show.
double pairedP(const PieceErrors& before, const PieceErrors& after);

}  // namespace simgap
