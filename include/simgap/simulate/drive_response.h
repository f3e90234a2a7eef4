/// \file
/// The simulated response of a drive to a log's inputs.
#pragma once

#include <span>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// How late channels are against the velocity (the voltage against the current, where there is no velocity), in rows.
struct DriveDelays {
  double input = 0.0;    ///< of the voltage, or of the current where it drives
  double current = 0.0;  ///< of the measured current, where the voltage drives
};

/// What is simulated. The winding alone takes its velocity from the log, so that no torque matters that is not in it.
enum class DriveExtent { kWhole, kWinding };

/// Response of a drive to a log's inputs, from the measured state at the start of each session.
struct DriveResponse {
  std::vector<double> current, velocity;  ///< shape (rows) [A], [rad/s] of the motor
};
DriveResponse simulateDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox,
                            const DriveDelays& delays = {}, DriveExtent extent = DriveExtent::kWhole);

/// The same of one session. Fills current and velocity, shape (rows of the block). Inputs are held between the instants
/// at which they were sampled, which lie `delays` before their rows; before the first and behind the last row they
/// stay. \param extent  a winding alone needs the log's voltage, current and velocity.
void simulateSession(const MotorLog& log, const Block& rows, const Motor& motor, const Gearbox& gearbox,
                     const DriveDelays& delays, DriveExtent extent, std::span<double> current,
                     std::span<double> velocity);

}  // namespace simgap
