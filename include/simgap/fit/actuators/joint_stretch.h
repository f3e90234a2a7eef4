/// \file
/// The joint's angle from the motor's, by what a diagnosed model says of the cable between them (003 fig. 15a):
///
///     theta = theta_M / r + offset - lag w_M - (compliance tau - hardening tau |tau|)
///
/// Offset and lag belong to the encoders of a log, not to the drive: where the log has both angles they are found in
/// it, for a stiff cable as for an elastic one; otherwise they are 0.
#pragma once

#include <optional>
#include <vector>

#include "simgap/fit/actuators/prediction.h"

namespace simgap {

/// Rows of one cell of load and angle.
struct StretchCell {
  double load, angle;  ///< [N m], [rad] its middle
  double rows;
  double measured, modelled;  ///< [rad] of the joint, the mean
};

struct JointStretch {
  Prediction angle;                 ///< of the joint; measured where the log has it
  std::optional<double> stiff_rms;  ///< [rad] of a cable that does not stretch
  double offset = 0.0, lag = 0.0;   ///< [rad], [s]
  double compliance, hardening;     ///< [rad/(N m)], [rad/(N m)^2]
  double largest_load = 0.0;        ///< [N m]
  std::vector<StretchCell> cells;   ///< with rows; empty where the log has one angle alone

  double stretch(double load) const;    ///< [rad]
  double stiffness(double load) const;  ///< [N m/rad] there; infinite where the law has used up all of its compliance
};

/// \throws ConfigError: a model without `transmission-compliance`; DataError: no motor's position, no load, no ratio
JointStretch predictJointAngle(const FittedModel& model, const CsvTable& table, const Bench& bench);

}  // namespace simgap
