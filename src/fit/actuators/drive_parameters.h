/// \file
/// The parameters of a drive's fit, their bounds, and what their first guess is.
#pragma once

#include <vector>

#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

/// Places in theta.
enum Parameter : std::size_t {
  kR,
  kL,
  kKe,
  kKt,
  kJm,
  kMuM,
  kTauM,
  kEta,
  kTauG,
  kMuG,
  kJg,
  kVoltageDelay,
  kCurrentDelay,
  kCount
};
static_assert(kEta == kMotorParameters && kVoltageDelay == kDriveParameters);

/// Bounds, and which are fixed, shape (kCount). \param step  between two rows [s]
std::vector<ParameterSpec> driveParameters(const DriveFitOptions& options, double step = 1.0);

/// Sizes at which the parameters matter on this log, shape (kCount): friction that takes a tenth of the torque, a delay
/// of one row.
std::vector<double> typicalSizes(const MotorLog& log, std::span<const double> theta, double ratio);

/// Between two rows, on average [s].
double meanStep(const MotorLog& log);

/// The delays among the parameters, in rows. \param step  as meanStep
DriveDelays delaysOf(const MotorLog& log, std::span<const double> theta, double step);

/// Whether a log has a channel, and it says something.
bool varies(const std::vector<double>& channel);

/// The multiple regressions of 000: V on (i, di/dt, w), then the torque balance on (dw/dt, w, sign w).
/// \returns shape (kCount)
/// \throws DataError: a load, current or velocity with the opposite sign, a load that the current does not follow.
std::vector<double> driveFirstGuess(const MotorLog& log, const DriveFitOptions& options);

}  // namespace simgap
