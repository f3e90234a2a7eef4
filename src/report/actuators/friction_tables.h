/// \file
/// The tables behind the pictures of a friction fit: 003 figures 10, 12-14 and 16 on the user's data.
#pragma once

#include "simgap/report/actuators/friction_report.h"

namespace simgap {

/// Per cell of torque x velocity: rows, and mean absolute error of every law.
std::string mapsCsv(const FrictionReport& report);

/// Whether the data reach each requirement.
std::vector<std::pair<std::string, std::string>> requirementSentences(const FrictionReport& report);

/// Friction over velocity in up to four bands of load: measured rows (what the effort yields beyond the load, by the
/// best law's k_a), and the curve of every law at the band's middle, by the same k_a.
std::string curvesCsv(const FrictionReport& report);
/// Friction of the best law over velocity, at the middle of each band.
std::string frictionCsv(const FrictionReport& report);
/// Parameters of every law.
std::string modelsCsv(const FrictionReport& report);
/// How many rows lie at which velocity of motor and joint, load and angle (003 figures 10b and c).
std::string histogramsCsv(const FrictionReport& report);
/// Working points that the drive has to reach, as the motor sees them.
std::string requirementsCsv(const FrictionReport& report);

}  // namespace simgap
