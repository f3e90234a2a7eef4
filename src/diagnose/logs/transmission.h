/// \file
/// Whether the transmission between motor and joint gives under load: the same search as for the effort, on the angles.
#pragma once

#include "held_out.h"

namespace simgap {

/// Adds transmission-compliance to a finished diagnosis of a drive's effort, where the log's two angles show it: the
/// gain is that of the joint's angle.
void addTransmission(const ActuatorModel& subject, const PreparedLog& log, const LogSplit& split,
                     const LogDiagnosisOptions& options, LogDiagnosis& result);

}  // namespace simgap
