/// \file
/// Commands that an arm's muscles can follow.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/measure/motion_commands.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// Whether a shaft's angle winds up, or lets out, more line than a muscle of this length can have: it belongs to
/// another arm, or is in another unit. \param shaft  [rad]
bool windsTooFar(const Muscle& muscle, double shaft);

/// What a muscle cannot be told: a set-point that winds too far, a voltage beyond its supply, a force that pushes;
/// empty when it can.
std::string problemOf(const Muscle& muscle, CommandKind kind, double value);

/// The same of a line that takes a command: a pressure below 0.
std::string problemOf(const PassiveTendon& tendon, double value);
/// Lines that take a command, in the order of PoseLayout::lines.
std::vector<const PassiveTendon*> commandedLines(const ArmModel& model);

/// Calls `fail` with the row and a sentence at the first command that a muscle or line cannot be told.
void refuseImpossible(const ArmModel& model, const MotionCommands& commands,
                      const std::function<void(std::size_t row, const std::string& sentence)>& fail);

/// Reads the commands of an arm's muscles and lines. \throws DataError as the reader of a table
/// (measure/motion_commands.h), and as refuseImpossible
MotionCommands readCommands(const CsvTable& table, const ArmModel& model, bool linear);

}  // namespace simgap
