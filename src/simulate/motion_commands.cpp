#include "simgap/simulate/motion_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::array kKinds = {CommandKind::kSetpoint, CommandKind::kVoltage, CommandKind::kForce};

std::string stemOf(CommandKind kind, const std::string& muscle) {
  return fmt::format("{}_{}", columnOf(kind).stem, muscle);
}

CommandKind kindOfCommand(const CsvTable& table, const std::string& muscle) {
  std::optional<CommandKind> found;
  for (const CommandKind kind : kKinds) {
    if (!table.offersQuantity(stemOf(kind, muscle), columnOf(kind).unit)) continue;
    if (found) {
      throw DataError(fmt::format("{}: {} and {}, expected one command per muscle", table.name(),
                                  stemOf(*found, muscle), stemOf(kind, muscle)));
    }
    found = kind;
  }
  if (found) return *found;
  throw DataError(fmt::format("{}: no command for muscle {}: expected setpoint_{}_rad, voltage_{}_V or force_{}_N",
                              table.name(), muscle, muscle, muscle, muscle));
}

/// A column that begins like a command belongs to a muscle of the model.
void expectKnownMuscles(const CsvTable& table, const ArmModel& model) {
  std::vector<std::string> names;
  for (const Muscle& muscle : model.muscles) names.push_back(muscle.name);
  for (const std::string& column : table.columns()) {
    for (const CommandKind kind : kKinds) {
      const std::string stem = std::string(columnOf(kind).stem) + "_";
      if (!column.starts_with(stem)) continue;
      const bool known = std::ranges::any_of(names, [&](const std::string& name) {
        return column.substr(stem.size()).starts_with(name + "_") || column.substr(stem.size()) == name;
      });
      if (known) continue;
      throw DataError(fmt::format("{}: column {}: {} has no such muscle, expected one of {}", table.name(), column,
                                  model.name, fmt::join(names, ", ")));
    }
  }
}

void expectPossible(const CsvTable& table, const Muscle& muscle, CommandKind kind, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string problem = problemOf(muscle, kind, values[i]);
    if (!problem.empty()) table.fail(i, fmt::format("{}: {}", stemOf(kind, muscle.name), problem));
  }
}

}  // namespace

CommandColumn columnOf(CommandKind kind) {
  switch (kind) {
    case CommandKind::kSetpoint:
      return {"setpoint", "rad"};
    case CommandKind::kVoltage:
      return {"voltage", "V"};
    case CommandKind::kForce:
      break;
  }
  return {"force", "N"};
}

std::string problemOf(const Muscle& muscle, CommandKind kind, double value) {
  const double supply = muscle.motor.supply_voltage;
  if (kind == CommandKind::kVoltage && std::abs(value) > supply) {
    return fmt::format("{:g} V is beyond the supply of {:g} V", value, supply);
  }
  if (kind == CommandKind::kForce && value < 0.0) return fmt::format("{:g} N, expected >= 0: a line only pulls", value);
  return "";
}

void MotionCommands::at(double time, std::size_t& row, std::span<double> out) const {
  if (row >= times.size() || times[row] > time) row = 0;
  while (row + 1 < times.size() && times[row + 1] <= time) ++row;
  double part = 0.0;
  if (linear && row + 1 < times.size() && time > times[row]) {
    part = (time - times[row]) / (times[row + 1] - times[row]);
  }
  const auto column = static_cast<Eigen::Index>(row);
  for (std::size_t m = 0; m < out.size(); ++m) {
    const auto i = static_cast<Eigen::Index>(m);
    out[m] = values(i, column);
    if (part > 0.0) out[m] += part * (values(i, column + 1) - out[m]);
  }
}

std::vector<double> readRisingTimes(const CsvTable& table) {
  std::vector<double> times = table.quantity("time", "s");
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    table.fail(i, fmt::format("time_s: {:g} after {:g}, expected times that rise", times[i], times[i - 1]));
  }
  return times;
}

MotionCommands readCommands(const CsvTable& table, const ArmModel& model, bool linear) {
  if (table.rows() == 0) throw DataError(table.name() + ": no rows, expected commands over time");
  expectKnownMuscles(table, model);
  MotionCommands commands;
  commands.linear = linear;
  commands.times = readRisingTimes(table);
  commands.values.resize(std::ssize(model.muscles), std::ssize(commands.times));
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    const Muscle& muscle = model.muscles[m];
    const CommandKind kind = kindOfCommand(table, muscle.name);
    const std::vector<double> values = table.quantity(stemOf(kind, muscle.name), columnOf(kind).unit);
    expectPossible(table, muscle, kind, values);
    commands.kinds.push_back(kind);
    commands.values.row(static_cast<Eigen::Index>(m)) =
        Eigen::Map<const Eigen::RowVectorXd>(values.data(), std::ssize(values));
  }
  return commands;
}

}  // namespace simgap
