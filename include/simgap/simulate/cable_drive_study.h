/// \file
/// A drive that follows its commands without its friction compensated, and with each compensation that its file names.
#pragma once

#include <string>
#include <vector>

#include "simgap/simulate/cable_drive_motion.h"

namespace simgap {

struct ComparedDrive {
  std::string name;
  double share = 0.0;  ///< of the friction that is compensated
  DriveRun run;
};

struct CableDriveStudy {
  std::vector<ComparedDrive> runs;  ///< "none" comes first
  double start = 0.0, end = 0.0;    ///< [s]
  double step = 0.0;                ///< [s]
  double half_step = 0.0;           ///< what half the step changes of the first run's RMS error, as a part of it
  std::vector<std::string> notes;   ///< what a reader must know before believing it
};

/// \param end [s] \param step  largest of the integration [s] \param row_rate  of the tracks [Hz]
/// \throws NumericsError: as playCableDrive
CableDriveStudy studyCableDrive(const CableDrive& drive, const CableDriveCommands& commands, double end, double step,
                                double row_rate);

}  // namespace simgap
