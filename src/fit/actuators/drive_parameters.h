/// \file
/// The parameters of a drive's fit, their bounds, and what their first guess is.
#pragma once

#include <vector>

#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

/// Places in theta.
enum Parameter : std::size_t { kR, kL, kKe, kKt, kJm, kMuM, kTauM, kEta, kTauG, kMuG, kJg, kCount };
inline constexpr std::size_t kFirstOfGearbox = kEta;

/// Bounds, and which are fixed, shape (kCount).
std::vector<ParameterSpec> driveParameters(const DriveFitOptions& options);

/// Whether a log has a channel, and it says something.
bool varies(const std::vector<double>& channel);

/// The multiple regressions of 000: V on (i, di/dt, w), then the torque balance on (dw/dt, w, sign w).
/// \returns shape (kCount)
std::vector<double> driveFirstGuess(const MotorLog& log, const DriveFitOptions& options);

}  // namespace simgap
