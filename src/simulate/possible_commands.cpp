#include "simgap/simulate/possible_commands.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

std::string problemOf(const Muscle& muscle, CommandKind kind, double value) {
  const double supply = muscle.motor.supply_voltage;
  if (kind == CommandKind::kVoltage && std::abs(value) > supply) {
    return fmt::format("{:g} V is beyond the supply of {:g} V", value, supply);
  }
  if (kind == CommandKind::kForce && value < 0.0) return fmt::format("{:g} N, expected >= 0: a line only pulls", value);
  return "";
}

void refuseOtherDrives(const ArmModel& model) {
  for (const PassiveTendon& tendon : model.tendons) {
    if (!tendon.kind->command) continue;
    throw ConfigError(fmt::format(
        "{}: '{}' is a {}, which no motion has a command for, expected muscles that a motor winds; poses command it "
        "(validate, calibrate, design, diagnose)",
        model.name, tendon.name, tendon.kind->name));
  }
}

void refuseImpossible(const ArmModel& model, const MotionCommands& commands,
                      const std::function<void(std::size_t row, const std::string& sentence)>& fail) {
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    const Muscle& muscle = model.muscles[m];
    for (std::size_t row = 0; row < commands.times.size(); ++row) {
      const double value = commands.values(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(row));
      const std::string problem = problemOf(muscle, commands.kinds[m], value);
      if (problem.empty()) continue;
      fail(row, fmt::format("{}_{}: {}", columnOf(commands.kinds[m]).stem, muscle.name, problem));
    }
  }
}

MotionCommands readCommands(const CsvTable& table, const ArmModel& model, bool linear) {
  MotionCommands commands = readCommands(table, model.poseLayout().muscles, linear);
  refuseImpossible(model, commands, [&](std::size_t row, const std::string& sentence) { table.fail(row, sentence); });
  return commands;
}

}  // namespace simgap
