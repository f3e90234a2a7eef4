/// \file
/// What a trial's own parameters say, beside what it gains: whether any others could stand in for them, and whether
/// they are further from none than chance leaves them.
#pragma once

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

/// How alike two causes change the residual of a model that has neither, over the rows that all count: their
/// correlation, -1 to 1.
double likeness(const Fitted& base, const Fitted& one, const Fitted& other);

}  // namespace simgap
