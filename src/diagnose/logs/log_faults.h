/// \file
/// What is wrong with a log before any physics: clipped, stuck or dropped channels, mirrored ones, spikes.
#pragma once

#include <vector>

#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap {

/// Faults that the channels show by themselves and against each other.
std::vector<DataFault> findFaults(PreparedLog& log);

/// Rows far off the model that stand alone or a few together, away from reversals, or a session's beginning that is
/// like nothing else: they are taken out of `log` (and said so) when they are few. \param residual  shape (rows) of a
/// fitted model, 0 where a row does not count. \param flipped of the same model with all directions reversed, or empty:
/// then rows of slow motion stay, whose direction may be wrong.
std::vector<DataFault> takeOutSpikes(PreparedLog& log, const Eigen::VectorXd& residual,
                                     const Eigen::VectorXd& flipped = {});

/// Rows within the dead band whose effort lies clearly between what both directions of motion would need, or is what
/// the other one needs: a reversal too slow to be seen. They are taken out of `log`. \param residual  of a fitted
/// model; \param flipped  of the same model with all directions reversed. \returns how many.
std::size_t takeOutUndecided(PreparedLog& log, const Eigen::VectorXd& residual, const Eigen::VectorXd& flipped);

}  // namespace simgap
