/// \file
/// What the log of a drive that lacks a channel cannot say, and what is taken instead.
#pragma once

#include <string>
#include <vector>

#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

/// Fixes in `options`, or ties to another parameter, what the log cannot say anything about; says so in `warnings`.
/// \returns names of the parameters that cannot be found: they get a placeholder that nothing depends on.
/// \throws DataError: a channel without which nothing is found, a current or velocity with the opposite sign.
std::vector<std::string> settleMissing(const MotorLog& log, DriveFitOptions& options,
                                       std::vector<std::string>& warnings);

/// What is tied to another parameter takes its estimate over; what is missing has none.
void settleEstimates(Uncertainty& uncertainty, const DriveFitOptions& options, const std::vector<std::string>& missing);

}  // namespace simgap
