/// \file
/// The simulated response of a drive to a log's inputs, one session at a time.
#pragma once

#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

/// Fills current and velocity, shape (rows of the block), of one session. Inputs are held between the instants at which
/// they were sampled, which lie `delays` before their rows; before the first and behind the last row they stay.
void simulateSession(const MotorLog& log, const Block& rows, const Motor& motor, const Gearbox& gearbox,
                     const DriveDelays& delays, std::span<double> current, std::span<double> velocity);

}  // namespace simgap
