#include "simgap/simulate/motion_inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "position_reach.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {

MotionStart readMotionStart(const CsvTable& table, const ArmModel& model, const std::string& pose) {
  if (table.rows() == 0) throw DataError(table.name() + ": no rows, expected a state");
  std::size_t row = 0;
  if (!pose.empty()) {
    const std::vector<std::string> names = table.text("pose");
    const auto found = std::ranges::find(names, pose);
    if (found == names.end()) throw DataError(fmt::format("{}: no pose '{}'", table.name(), pose));
    row = static_cast<std::size_t>(found - names.begin());
  }
  MotionStart start;
  for (const Joint& joint : model.joints) start.joints.push_back(kindOf(joint.type).read(table, joint.name)[row]);
  for (const Muscle& muscle : model.muscles) {
    start.shafts.push_back(table.quantity("shaft_" + muscle.name, "rad")[row]);
  }
  refuseStartOutOfReach(model, start.joints, table.name(), pose.empty() ? "row 1" : "pose " + pose);
  coupleJoints(model, start.joints);  // what is measured agrees with them but for its noise
  return start;
}

MeasuredMotion readMeasuredJoints(const CsvTable& table, const ArmModel& model, double start, double end) {
  const std::vector<double> times = readRisingTimes(table);
  std::vector<std::vector<JointPosition>> columns;
  for (const Joint& joint : model.joints) columns.push_back(kindOf(joint.type).read(table, joint.name));
  MeasuredMotion measured{table.name(), {}, {}, {}};
  for (std::size_t row = 0; row < times.size(); ++row) {
    if (times[row] < start || times[row] > end) continue;
    measured.times.push_back(times[row]);
    for (const auto& column : columns) measured.joints.push_back(column[row]);
  }
  if (measured.times.empty()) {
    throw DataError(fmt::format("{}: no row between {:g} and {:g} s, expected a clock that overlaps the commands'",
                                table.name(), start, end));
  }
  return measured;
}

double motionEnd(const MotionCommands& commands, const std::string& file, const std::optional<double>& duration) {
  if (duration) return commands.times.front() + *duration;
  if (commands.end() > commands.times.front()) return commands.end();
  throw DataError(file + ": one row of commands, expected --duration-s with it: how long they are held");
}

}  // namespace simgap
