#include "simgap/simulate/possible_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

bool windsTooFar(const Muscle& muscle, double shaft) {
  constexpr double kMostLengths = 2.0, kShortestLimit = 0.5;  // [m], for muscles of no length
  const double length = muscle.kite_line_length + muscle.shock_cord.rest_length;
  return muscle.spindle_radius * std::abs(shaft) > std::max(kMostLengths * length, kShortestLimit);
}

std::string problemOf(const Muscle& muscle, CommandKind kind, double value) {
  const double supply = muscle.motor.supply_voltage;
  if (kind == CommandKind::kVoltage && std::abs(value) > supply) {
    return fmt::format("{:g} V is beyond the supply of {:g} V", value, supply);
  }
  if (kind == CommandKind::kForce && value < 0.0) return fmt::format("{:g} N, expected >= 0: a line only pulls", value);
  if (kind == CommandKind::kSetpoint && windsTooFar(muscle, value)) {
    return fmt::format("{:g} rad winds {:.3g} m of line, expected angles in rad that a muscle of {:.3g} m allows",
                       value, muscle.spindle_radius * std::abs(value),
                       muscle.kite_line_length + muscle.shock_cord.rest_length);
  }
  return "";
}

std::string problemOf(const PassiveTendon& tendon, double value) {
  const TendonCommand& command = tendon.kind->command;
  if (value >= command.lowest) return "";
  return fmt::format("{:g} {}, expected >= {:g}", value, command.unit, command.lowest);
}

std::vector<const PassiveTendon*> commandedLines(const ArmModel& model) {
  std::vector<const PassiveTendon*> lines;
  for (const PassiveTendon& tendon : model.tendons) {
    if (tendon.kind->command) lines.push_back(&tendon);
  }
  return lines;
}

void refuseImpossible(const ArmModel& model, const MotionCommands& commands,
                      const std::function<void(std::size_t row, const std::string& sentence)>& fail) {
  const std::vector<const PassiveTendon*> lines = commandedLines(model);
  const std::size_t muscles = model.muscles.size();
  for (std::size_t i = 0; i < muscles + lines.size(); ++i) {
    for (std::size_t row = 0; row < commands.times.size(); ++row) {
      const double value = commands.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(row));
      const std::string problem =
          i < muscles ? problemOf(model.muscles[i], commands.kinds[i], value) : problemOf(*lines[i - muscles], value);
      if (problem.empty()) continue;
      const std::string column = i < muscles
                                     ? fmt::format("{}_{}", columnOf(commands.kinds[i]).stem, model.muscles[i].name)
                                     : lines[i - muscles]->commandStem();
      fail(row, fmt::format("{}: {}", column, problem));
    }
  }
}

MotionCommands readCommands(const CsvTable& table, const ArmModel& model, bool linear) {
  MotionCommands commands = readCommands(table, model.poseLayout(), linear);
  refuseImpossible(model, commands, [&](std::size_t row, const std::string& sentence) { table.fail(row, sentence); });
  return commands;
}

}  // namespace simgap
