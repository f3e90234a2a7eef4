/// \file
/// An arm as it was measured by hand, as it really is, and what a rig records of it.
#pragma once

#include <cstdint>
#include <vector>

#include "reality/arm_statics.h"

namespace simgap::reality {

struct RigOptions {
  int calibration = 15;
  int validation = 15;
  int repeats = 1;                                   ///< of each calibration pose
  double capture_sd = 0.3 * 3.14159265358979 / 180;  ///< per component of a joint [rad]
  /// \name How well hands measure (standard deviations; stiffness and radius relative, log-normal)
  ///@{
  double proximal = 7.0e-3, distal = 3.5e-3;  ///< attachments [m]
  double kite_line = 11.0e-3;                 ///< [m]
  double stiffness = 0.13, radius = 0.05;
  ///@}
  bool friction = true;    ///< joints rest anywhere their Coulomb friction holds them
  double coiling = 0.0;    ///< of every spindle, see Muscle [m/rad^2]
  double hardening = 0.0;  ///< of every cord, see Muscle (1)
  int flipped = 0;         ///< calibration poses whose marker identities were swapped: turned by some 90 deg
};

struct RecordedPose {
  std::vector<double> shafts;
  Configuration joints;
};

struct Rig {
  Arm nominal;  ///< what the hands measured
  Arm truth;
  std::vector<std::vector<RecordedPose>> calibration;  ///< shape (poses, repeats)
  std::vector<RecordedPose> validation;
};

/// The reference arm's twin; a pure function of its arguments.
Rig makeRig(std::uint64_t seed, const RigOptions& options = {});
/// The twin of another arm.
Rig makeRig(const Arm& nominal, std::uint64_t seed, const RigOptions& options = {});

/// What the rig records when the truth is commanded to these shafts. \param draw  numbers the noise
RecordedPose record(const Arm& truth, const std::vector<double>& shafts, const RigOptions& options, std::uint64_t draw);

}  // namespace simgap::reality
