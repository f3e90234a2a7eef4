/// \file
/// A fitted drive or cord on its way into an arm, and into the calibration of that arm.
#pragma once

#include <string>

#include "simgap/model/arm/arm.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

/// An arm that gets the fitted drive or cord.
struct ArmWithDrive {
  ArmModel arm;
  std::size_t muscle = 0;  ///< whose it is
};

/// The arm with that motor in the one muscle; the supply voltage, which no fit knows, stays the arm's.
ArmModel withMotor(const ArmWithDrive& target, const Motor& motor);
/// The arm with that gearbox in the one muscle.
ArmModel withGearbox(const ArmWithDrive& target, const Gearbox& gearbox);

/// The estimates as priors of that muscle's parameters, YAML for the `parameters:` of a calibration config; what is
/// fixed or unknown is left out.
std::string calibrationParameters(const std::string& muscle, const Uncertainty& uncertainty);

}  // namespace simgap
