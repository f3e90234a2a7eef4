/// \file
/// A joint of muscles and motor under its commands, with a controller that knows of the tendons and with one that does
/// not, each with and without the motor (002 fig. 8).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/simulate/exo_joint_motion.h"

namespace simgap {

/// How well a desired torque was met over the ticks. [N m]
struct TorqueTracking {
  double rms = 0.0;        ///< of desired - muscles - motor
  double largest = 0.0;    ///< the largest size of it
  double motor_rms = 0.0;  ///< of the motor's torque
  double motor_largest = 0.0;
  double at_limit = 0.0;  ///< share of ticks at which the motor was at its limit and torque was missing
};

struct ExoJointRun {
  std::string name;  ///< "tendon_motor", "tendon_alone", "rigid_motor", "rigid_alone"; "pressures"
  ExoJointPlay play;
  ExoJointTrack track;
  TorqueTracking tracking;  ///< where a torque is desired
};

struct ExoJointStudy {
  std::vector<ExoJointRun> runs;   ///< the joint as its file has it comes first
  double start = 0.0, end = 0.0;   ///< [s]
  std::optional<double> obeyed;    ///< of a switch: share of ticks on the told side of the middle of the way
  double half_step = 0.0;          ///< what half the step changes of the first run's angle [rad]
  double processor = 0.0;          ///< [s] of one core, of the first run
  double simulated = 0.0;          ///< [s], with settling
  std::vector<std::string> notes;  ///< what a reader must know before believing the first run

  const ExoJointRun& main() const { return runs.front(); }
  double realTimeFactor() const;
};

/// \param end  [s] \param step  largest step of the integration [s]  \throws NumericsError: as playExoJoint
ExoJointStudy studyExoJoint(const ExoJoint& joint, const ExoJointCommands& commands, double end, double step);

}  // namespace simgap
