/// \file
/// What a trial's own parameters say, beside what it gains: whether any others could stand in for them, and whether
/// they are further from none than chance leaves them.
#pragma once

#include <string>
#include <vector>

#include "log_hypotheses.h"

namespace simgap {

/// The share of an effect's signature that the other parameters cannot imitate, over its parameters the largest.
/// \param at  the model's place  \param effect  its index
double distinctShare(const ActuatorRegression& model, const RowEvaluation& at, std::span<const Block> blocks,
                     std::size_t effect);

/// p-value of "the last effect's sizes are neutral" from their covariance over pieces of the log (Wald 1943), for the
/// largest of them, times the number of places a search may have looked at. A covariance from few pieces is too small
/// and says nothing.
double waldP(const ActuatorRegression& model, const RowEvaluation& at, const std::vector<Block>& pieces);

/// Whether a cause says what a better one does. Those of one kin (friction by the load and by the angle, of a pendulum)
/// that change the model's rows alike say the same function, each by a law of its own that the true one may not have: a
/// small lead is one of laws. \param base  the model without either
bool saysTheSame(const Fitted& base, const Trial& winner, const Trial& other);

/// How many numbers a cause fits.
std::size_t sizesOf(const ActuatorEffect& effect);

/// The first few of different causes.
std::vector<const Trial*> oneOfEach(const std::vector<const Trial*>& trials, std::size_t most);

/// Causes none of whose forms the model's own parameters leave anything to say.
std::vector<std::string> aliased(const std::vector<Trial>& trials);

}  // namespace simgap
