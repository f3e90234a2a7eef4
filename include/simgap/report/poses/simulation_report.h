/// \file
/// The result of `simulate` as JSON (docs/formats.md), files and a table for the terminal.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/report/table.h"
#include "simgap/simulate/motion_inputs.h"
#include "simgap/simulate/simulation.h"

namespace simgap {

struct SimulationResult {
  const ArmModel& model;
  const MotionCommands& commands;
  const SimulationOptions& options;
  const Simulation& simulation;
  std::string start;  ///< "rest", "zero" or a file
  std::optional<MeasuredMotion> measured = {};
  std::vector<std::string> notes = {};
};

Json toJson(const SimulationResult& result);
std::string terminalTable(const SimulationResult& result);
/// motion.csv, muscles.csv, joints.csv, the scene's arm_*.csv, and measured.csv where a movement was given.
void writeSimulation(const SimulationResult& result, std::uint64_t seed, const RunDirectory& directory);

/// Per joint and per muscle, from the JSON.
Table jointMotionTable(const Json& result);
Table muscleMotionTable(const Json& result);
Table lineMotionTable(const Json& result);  ///< of what takes a command besides muscles

}  // namespace simgap
