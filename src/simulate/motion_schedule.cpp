#include "simgap/simulate/motion_schedule.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "schedule_line.h"

namespace simgap {
namespace {

/// Of a muscle or of a line that takes a command.
struct Line : ScheduleLine {
  CommandKind kind = CommandKind::kSetpoint;
  std::string own_unit = {};  ///< of a line's command; empty: a muscle's
  std::string_view unit() const { return own_unit.empty() ? columnOf(kind).unit : std::string_view(own_unit); }
};

CommandKind readKind(const YamlNode& node) {
  const std::string name = node.oneOf({"setpoint", "voltage", "force"});
  if (name == "setpoint") return CommandKind::kSetpoint;
  return name == "voltage" ? CommandKind::kVoltage : CommandKind::kForce;
}

int muscleIndex(const ArmModel& model, const std::string& name) {
  const auto found = std::ranges::find(model.muscles, name, &Muscle::name);
  return found == model.muscles.end() ? -1 : static_cast<int>(found - model.muscles.begin());
}

std::string muscleNames(const ArmModel& model) {
  std::vector<std::string> names;
  for (const Muscle& muscle : model.muscles) names.push_back(muscle.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// `all:` segments lead every muscle: to a pose, lines too, or hold a value.
void readAll(const YamlNode& node, const PoseSet* poses, std::vector<Line>& lines) {
  for (const YamlNode& item : node.items()) {
    const auto name = item.find("pose");
    if (!name) {
      for (Line& line : lines) {
        if (line.own_unit.empty()) line.segments.push_back(readSegment(item, line, line.unit()));
      }
      continue;
    }
    if (poses == nullptr) name->fail("found a pose, expected `poses: FILE` beside `all`, which has it");
    const auto pose = std::ranges::find(poses->poses, name->text(), &Pose::name);
    if (pose == poses->poses.end()) name->fail(fmt::format("{} has no pose '{}'", poses->file, name->text()));
    for (std::size_t m = 0; m < lines.size(); ++m) {
      if (lines[m].own_unit.empty() && lines[m].kind != CommandKind::kSetpoint)
        name->fail("a pose is made of set-points, expected command: setpoint");
      ScheduleSegment segment = beginSegment(item, lines[m]);
      segment.to = pose->shafts[m];
      if (segment.duration == 0.0) segment.from = segment.to;
      lines[m].segments.push_back(segment);
    }
  }
}

void readMuscles(const YamlNode& node, const ArmModel& model, std::vector<Line>& lines) {
  for (const std::string& name : node.keys()) {
    const YamlNode entry = node.at(name);
    const int m = muscleIndex(model, name);
    if (m < 0) entry.fail(fmt::format("{} has no such muscle, expected one of {}", model.name, muscleNames(model)));
    Line& line = lines[m];
    if (const auto kind = entry.find("command")) {
      const CommandKind own = readKind(*kind);
      if (own != line.kind && !line.segments.empty()) kind->fail("differs from what `all` commands");
      line.kind = own;
    }
    for (const YamlNode& item : entry.at("segments").items())
      line.segments.push_back(readSegment(item, line, line.unit()));
  }
}

void readLines(const YamlNode& node, const ArmModel& model, std::span<Line> lines) {
  const std::vector<const PassiveTendon*> tendons = commandedLines(model);
  for (const std::string& name : node.keys()) {
    const YamlNode entry = node.at(name);
    const auto found = std::ranges::find(tendons, name, &PassiveTendon::name);
    if (found == tendons.end()) entry.fail(model.name + " has no such line that takes a command");
    Line& line = lines[found - tendons.begin()];
    for (const YamlNode& item : entry.at("segments").items())
      line.segments.push_back(readSegment(item, line, line.unit()));
  }
}

MotionCommands sampled(const YamlNode& root, const ArmModel& model, const std::vector<Line>& lines, double duration,
                       double rate) {
  MotionCommands commands;
  const auto rows = static_cast<Eigen::Index>(scheduleRows(root, duration, rate));
  commands.values.resize(std::ssize(lines), rows);
  for (Eigen::Index row = 0; row < rows; ++row) commands.times.push_back(static_cast<double>(row) / rate);
  for (std::size_t m = 0; m < lines.size(); ++m) {
    if (lines[m].own_unit.empty()) commands.kinds.push_back(lines[m].kind);
    for (Eigen::Index row = 0; row < rows; ++row) {
      const double value = lines[m].at(commands.times[row]);
      commands.values(static_cast<Eigen::Index>(m), row) = value;
    }
  }
  refuseImpossible(model, commands, [&](std::size_t row, const std::string& sentence) {
    root.fail(fmt::format("at {:g} s {}", commands.times[row], sentence));
  });
  return commands;
}

}  // namespace

MotionCommands readSchedule(const YamlNode& root, const ArmModel& model, double rate,
                            const std::function<PoseSet(const std::string& file)>& poses) {
  root.at("format").oneOf({"simgap/schedule/1"});
  std::vector<Line> lines(model.muscles.size());
  if (const auto kind = root.find("command")) {
    const CommandKind all = readKind(*kind);
    for (Line& line : lines) line.kind = all;
  }
  for (const PassiveTendon* tendon : commandedLines(model)) {
    lines.emplace_back().own_unit = tendon->kind->command.unit;
  }
  for (Line& line : lines) line.rate = rate;
  std::optional<PoseSet> set;
  if (const auto file = root.find("poses")) set = poses(file->text());
  if (const auto all = root.find("all")) readAll(*all, set ? &*set : nullptr, lines);
  if (const auto muscles = root.find("muscles")) readMuscles(*muscles, model, lines);
  if (const auto tendons = root.find("tendons")) {
    readLines(*tendons, model, std::span(lines).subspan(model.muscles.size()));
  }
  double end = 0.0;
  for (std::size_t m = 0; m < lines.size(); ++m) {
    if (lines[m].segments.empty()) {
      root.fail(m < model.muscles.size() ? fmt::format("no command for muscle {}", model.muscles[m].name)
                                         : fmt::format("no command for {} (under tendons:)",
                                                       commandedLines(model)[m - model.muscles.size()]->name));
    }
    end = std::max(end, lines[m].end());
  }
  const double duration = root.findQuantity("duration", "s", kPositive).value_or(end);
  root.expectAllRead();
  return sampled(root, model, lines, duration, rate);
}

}  // namespace simgap
