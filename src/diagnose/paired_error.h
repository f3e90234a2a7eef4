/// \file
/// Squared errors of two models on the same pieces of a log, compared piece by piece.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "simgap/core/random.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Sums of squared errors over groups of rows (short pieces of a log, or its sessions), shape (groups), and the rows in
/// each.
struct GroupErrors {
  Eigen::ArrayXd sum;
  Eigen::ArrayXd rows;
  double mse() const { return sum.sum() / rows.sum(); }
};

/// How much lower the error of `after` is than that of `before`, as a fraction, with a 95 % interval from a bootstrap
/// of runs of neighbouring pieces (moving blocks: Kunsch 1989). A pure function of its arguments.
Interval pairedGain(const GroupErrors& before, const GroupErrors& after, std::uint64_t seed);

/// The same of errors that are independent of each other, as those of poses are. \param before, after  shape (samples)
Interval pairedGain(std::span<const double> before, std::span<const double> after, std::uint64_t seed);

/// 1 - sum(after) / sum(before) of as many independent pieces, drawn with replacement: one draw of a paired bootstrap.
double resampledGain(const Eigen::ArrayXd& before, const Eigen::ArrayXd& after, const CounterRandom& random,
                     std::uint32_t draw, std::uint32_t purpose);

/// Explained : left of a gain, on a logarithmic scale; a gain of nothing counts as a small one. And back.
double logOdds(double gain);
double inverseLogOdds(double odds);

/// As pairedGain, from the errors on pieces (shape (pieces)) that decided nothing, and where it will be, with 95 %, on
/// as many other ones. That is a prediction: what was measured and what is to come are both drawn from the pieces again
/// and again, and differ as their draws do (prediction bootstrap: Stine 1985). A few pieces, of one load or speed, show
/// most of a cause: what varies evenly is the logarithm of explained : left, or, where those pieces are missing here,
/// the gain itself; upwards the wider counts. A pure function of its arguments.
Interval predictedGain(const Eigen::ArrayXd& before, const Eigen::ArrayXd& after, std::uint64_t seed);

/// One-sided p-value of "after is no better than before", the correlation of neighbouring pieces (AR(1)) counted:
/// three tests as one. The mean difference is what the error is made of, but a few pieces under large
/// loads rule it; the mean log ratio counts every piece alike; signed ranks find what only some pieces show.
double pairedP(const GroupErrors& before, const GroupErrors& after);

/// What a model adds to a smaller one that it contains, against the errors of the smaller, on pieces, shape (pieces).
struct Nested {
  Eigen::ArrayXd products;  ///< sums of errors times what is added
  Eigen::ArrayXd squares;   ///< sums of squares of what is added
};

/// One-sided p-value of "what the larger model adds is none of the truth". Squared errors ask that the larger pays for
/// the noise of its own parameters, too; the slope of the smaller's errors over what the larger adds does not, and
/// shows the same with half the standard deviations (Clark & West 2007). The slope's variance by leaving out each piece
/// (jackknife), the correlation of neighbours counted, with as many degrees of freedom as pieces carry it; signed ranks
/// find what only some pieces show: two tests as one.
double nestedP(const Nested& pieces);

}  // namespace simgap
