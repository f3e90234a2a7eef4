/// \file
/// Slips of units that a motor's two constants give away.
#pragma once

#include <string>

#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

/// A sentence where K_T and K_E are further apart than any motor's, with the slip that looks like it; empty otherwise.
std::string strangeConstants(const Estimate& emf, const Estimate& torque);

/// A sentence where the velocity is another than voltage and current give with a known motor, w = (V - R i) / K_E;
/// empty otherwise. \param ratio  of the gearbox, whose output the velocity may be of
std::string strangeVelocity(const MotorLog& log, const Motor& motor, double ratio);

}  // namespace simgap
