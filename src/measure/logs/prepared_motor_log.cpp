// A winding's log.
#include <fmt/format.h>

#include "prepared_rows.h"
#include "simgap/core/error.h"

namespace simgap {

PreparedLog prepareMotorData(const CsvTable& table) {
  const MotorLog motor = readMotorLog(table);
  for (const auto& [name, channel] :
       {std::pair("voltage_V", &motor.voltage), {"current_A", &motor.current}, {"velocity_rad_s", &motor.velocity}}) {
    if (channel->empty())
      throw DataError(fmt::format("{}:1: found no {}, expected it to diagnose a winding", motor.file, name));
  }
  PreparedLog log = prepared(ActuatorKind::kMotor, motor.file, motor.time, motor.session, motor.session_names);
  log.effort_column = "voltage_V";
  log.data.effort_unit = log.data.load_unit = "V";
  ActuatorRows& rows = log.data.rows;
  rows.effort = toArray(motor.voltage);
  rows.current = toArray(motor.current);
  rows.speed = toArray(motor.velocity);
  setDirection(motor.velocity, log);
  rows.current_rate = slopeOf(rows, rows.current, FrictionDataOptions::kDefaultBandwidth / rows.step);
  leaveOutJumps(rows.current_rate, log.data.keep);
  addOptional(table, log, {{"current", &rows.current}, {"velocity", &rows.speed}});
  return log;
}

}  // namespace simgap
