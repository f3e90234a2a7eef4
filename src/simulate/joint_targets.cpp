#include "simgap/simulate/joint_targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "position_reach.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

/// The first column of a joint's target; empty without one.
std::string jointTargetOf(const CsvTable& table, const ArmModel& model) {
  const std::vector<CommandChannel> lines = model.poseLayout().lines;  // a servo at a joint has a target, too
  const auto leads = [&](const std::string& column) {
    return column.starts_with("target_") &&
           std::ranges::find(lines, splitUnit(column).stem, &CommandChannel::stem) == lines.end();
  };
  const auto found = std::ranges::find_if(table.columns(), leads);
  return found == table.columns().end() ? "" : *found;
}

}  // namespace

void JointTargets::at(double time, const std::vector<Joint>& kinds, std::vector<JointPosition>& positions) const {
  const auto after = std::ranges::upper_bound(times, time) - times.begin();
  const auto row = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0));
  const bool between = linear && after > 0 && row + 1 < times.size();
  const double part = between ? (time - times[row]) / (times[row + 1] - times[row]) : 0.0;
  positions.resize(kinds.size());
  for (std::size_t j = 0; j < kinds.size(); ++j) {
    const JointPosition& now = joints[row * kinds.size() + j];
    positions[j] = part > 0.0 ? kindOf(kinds[j].type).between(now, joints[(row + 1) * kinds.size() + j], part) : now;
  }
}

bool hasJointTargets(const CsvTable& table, const ArmModel& model) { return !jointTargetOf(table, model).empty(); }

JointTargets readJointTargets(const CsvTable& table, const ArmModel& model, bool linear) {
  if (table.rows() == 0) throw DataError(table.name() + ": no rows, expected positions of joints over time");
  for (const std::string& column : table.columns()) {
    for (const std::string_view stem : {"setpoint_", "voltage_", "force_"}) {
      if (!column.starts_with(stem)) continue;
      throw DataError(fmt::format("{}:1: found both target_… and {}, expected joints or muscles to be commanded",
                                  table.name(), column));
    }
  }
  for (const PassiveTendon& tendon : model.tendons) {
    if (!tendon.kind->command) continue;
    throw DataError(
        fmt::format("{}:1: found {}, but '{}' is a {}: joints are led by muscles that a motor winds alone, "
                    "expected {}_{} and the commands of all others",
                    table.name(), jointTargetOf(table, model), tendon.name, tendon.kind->name, tendon.commandStem(),
                    tendon.kind->command.unit));
  }
  if (model.muscles.empty()) {
    throw DataError(fmt::format("{}:1: found target_…, but {} has no muscle, expected some that lead its joints",
                                table.name(), model.name));
  }
  JointTargets targets{readRisingTimes(table), {}, linear};
  const std::size_t joints = model.joints.size();
  targets.joints.resize(targets.times.size() * joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const auto positions = kindOf(model.joints[j].type).read(table, "target_" + model.joints[j].name);
    for (std::size_t row = 0; row < positions.size(); ++row) targets.joints[row * joints + j] = positions[row];
  }
  refusePositionsOutOfReach(
      model, {.file = table.name(),
              .count = targets.times.size(),
              .joints = [&](std::size_t row) { return std::span(targets.joints).subspan(row * joints, joints); },
              .place = [&](std::size_t row) { return fmt::format("{:g} s", targets.times[row]); },
              .stem = "target_"});
  return targets;
}

MotionCommands commandsFor(const JointTargets& targets, std::size_t muscles) {
  MotionCommands commands;
  commands.kinds.assign(muscles, CommandKind::kForce);
  commands.times = targets.times;
  commands.values = Eigen::MatrixXd::Zero(muscles, std::ssize(targets.times));
  return commands;
}

}  // namespace simgap
