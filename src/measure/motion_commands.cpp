#include "simgap/measure/motion_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
      throw DataError(fmt::format("{}:1: muscle {}: found both {} and {}, expected one kind of command", table.name(),
                                  muscle, stemOf(*found, muscle), stemOf(kind, muscle)));
    }
    found = kind;
  }
  if (found) return *found;
  throw DataError(
      fmt::format("{}:1: muscle {}: found no command, expected one of setpoint_{}_rad, voltage_{}_V, force_{}_N",
                  table.name(), muscle, muscle, muscle, muscle));
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

void MotionCommands::at(double time, std::size_t& row, std::span<double> out) const {
  // Ticks of a controller and rows of a log meet but for round-off: a tick later would be a command later.
  constexpr double kSameMoment = 1e-7;  // [s]
  const double now = time + kSameMoment;
  if (row >= times.size() || times[row] > now) row = 0;
  while (row + 1 < times.size() && times[row + 1] <= now) ++row;
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
  for (std::size_t row = 1; row < times.size(); ++row) {
    if (times[row] > times[row - 1]) continue;
    table.fail(row,
               fmt::format("time {}: found {} s behind {} s, expected rising times",
                           times[row] < times[row - 1] ? "goes back" : "stands still", times[row], times[row - 1]));
  }
  return times;
}

void refuseForeignMuscles(const CsvTable& table, const PoseLayout& layout, std::span<const std::string_view> stems) {
  const std::vector<std::string>& names = layout.muscles;
  for (const std::string& column : table.columns()) {
    for (const std::string_view stem : stems) {
      const std::string before = std::string(stem) + "_";
      if (!column.starts_with(before)) continue;
      const std::string named = splitUnit(column).stem;
      // A motor at a joint is commanded by a current, as a muscle's is measured.
      if (std::ranges::find(layout.lines, named, &CommandChannel::stem) != layout.lines.end()) continue;
      const std::string muscle = (named.starts_with(before) ? named : column).substr(before.size());
      if (std::ranges::find(names, muscle) != names.end()) continue;
      const std::string nearest = nearestName(muscle, names);
      throw DataError(fmt::format("{}:1: column {}: the model has no muscle '{}'{}", table.name(), column, muscle,
                                  nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", nearest)));
    }
  }
}

MotionCommands readCommands(const CsvTable& table, const PoseLayout& layout, bool linear) {
  if (table.rows() == 0) throw DataError(table.name() + ": no rows, expected commands over time");
  constexpr std::array<std::string_view, 3> kStems = {"setpoint", "voltage", "force"};
  refuseForeignMuscles(table, layout, kStems);
  MotionCommands commands;
  commands.linear = linear;
  commands.times = readRisingTimes(table);
  commands.values.resize(std::ssize(layout.muscles) + std::ssize(layout.lines), std::ssize(commands.times));
  Eigen::Index next = 0;
  const auto add = [&](const std::string& stem, std::string_view unit) {
    const std::vector<double> values = table.quantity(stem, unit);
    commands.values.row(next++) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), std::ssize(values));
  };
  for (const std::string& muscle : layout.muscles) {
    commands.kinds.push_back(kindOfCommand(table, muscle));
    add(stemOf(commands.kinds.back(), muscle), columnOf(commands.kinds.back()).unit);
  }
  for (const CommandChannel& line : layout.lines) add(line.stem, line.unit);
  return commands;
}

std::string commandsCsv(const MotionCommands& commands, const PoseLayout& layout) {
  std::vector<std::string> header = {"time_s"};
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    const auto [stem, unit] = columnOf(commands.kinds[m]);
    header.push_back(fmt::format("{}_{}_{}", stem, layout.muscles[m], unit));
  }
  for (const CommandChannel& line : layout.lines) header.push_back(fmt::format("{}_{}", line.stem, line.unit));
  CsvWriter csv(header);
  for (std::size_t row = 0; row < commands.times.size(); ++row) {
    csv.add(commands.times[row]);
    for (const double value : commands.values.col(row)) csv.add(value);
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
