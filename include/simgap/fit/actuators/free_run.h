/// \file
/// From effort to motion: how a fitted drive moves when it draws what the log says, told nothing of the motion but its
/// beginning. The sharpest test of a model: every error adds up.
#pragma once

#include "simgap/fit/actuators/prediction.h"

namespace simgap {

/// The position of every row, each session started from its first row as measured. Between two rows the effort is a
/// straight line, and the motion is integrated by the midpoint rule (Runge 1895) in steps of 2 ms at most. The equation
/// of effort is solved for the acceleration. At rest friction is a set: the drive stays while neither direction would
/// be left.
/// \param bench  gives the load and the inertia; constants that were fitted are taken from the model.
/// \throws ConfigError: no drive, or an effect that remembers what was before; DataError: no position in the log, no
/// inertia in the bench.
Prediction runFreely(const FittedModel& model, const CsvTable& table, const Bench& bench);

}  // namespace simgap
