/// \file
/// A movement of an arm from commands to what a rig would have logged, with what a user should know of its step.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/simulate/rollout.h"
#include "simgap/simulate/sensors.h"

namespace simgap {

struct SimulationOptions {
  RolloutOptions rollout;
  SensorOptions sensors;
  double rate = 100.0;  ///< of motion.csv [Hz]
  double settle = 1.5;  ///< [s] under the first commands, where a motion begins at rest

  /// `simgap/simulation/1`; what is missing keeps its value. \throws ConfigError
  static SimulationOptions read(const YamlNode& root);
  std::string toYaml() const;
};

/// The same motion at half the step.
struct StepCheck {
  bool finished = false;             ///< false: it blew up there
  std::vector<double> joint_change;  ///< shape (joints) [rad], of a slide [m], the largest over time
  double energy_change = 0.0;        ///< the largest over time, of the range of all or, if more, potential energy (1)
};

struct Simulation {
  double start = 0.0, end = 0.0;  ///< [s]
  MotionTrack motion;             ///< at SimulationOptions::rate
  MotionTrack muscles, joints;    ///< at the times of the sensors
  double processor = 0.0;         ///< [s] of one core that playing the motion took, settling included
  double simulated = 0.0;         ///< [s], settling included
  StepCheck check;
  double realTimeFactor() const { return simulated / std::max(processor, 1e-6); }
};

/// Where an arm rests under the commands of a moment: shafts at their set-points (0 under other commands), joints in
/// the equilibrium there, then the commands held for `settle`. [s]
MotionStart restUnder(const ArmModel& model, const MotionCommands& commands, double time, double settle);

/// Plays a motion. \param end  [s], on the commands' clock
/// \throws NumericsError: it blew up; when, which joint, and the step that holds
Simulation simulateMotion(const ArmModel& model, const MotionCommands& commands, const MotionStart& start, double end,
                          const SimulationOptions& options);

/// The motion at other times, as simulateMotion played it.
MotionTrack playAt(const ArmModel& model, const MotionCommands& commands, const MotionStart& start,
                   std::span<const double> times, const SimulationOptions& options);

/// What a user should know before believing a motion: motors that could not follow, a step too large. Empty where all
/// is well.
std::vector<std::string> notesOn(const ArmModel& model, const MotionCommands& commands, const Simulation& simulation,
                                 double step);

/// motion.csv: `time_s`, joints, their velocities, and per muscle `shaft_…_rad`, `cord_length_…_m`, `tension_…_N`,
/// `current_…_A`, `voltage_…_V`.
std::string motionCsv(const ArmModel& model, const MotionTrack& track);

}  // namespace simgap
