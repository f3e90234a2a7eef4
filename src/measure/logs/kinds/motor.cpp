// A winding's log.
#include <fmt/format.h>

#include "measure/logs/prepared_rows.h"
#include "simgap/core/error.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap::log_kinds::motor {
namespace {

PreparedLog prepare(const CsvTable& table, const Bench& /*bench*/, const FrictionDataOptions& /*options*/) {
  const MotorLog motor = readMotorLog(table);
  for (const auto& [name, channel] :
       {std::pair("voltage_V", &motor.voltage), {"current_A", &motor.current}, {"velocity_rad_s", &motor.velocity}}) {
    if (channel->empty())
      throw DataError(
          fmt::format("{}:1: found no {}, expected it to diagnose a winding (a drive's effort and motion alone: simgap "
                      "diagnose coulomb)",
                      motor.file, name));
  }
  PreparedLog log = prepared(ActuatorKind::kMotor, motor.file, motor.time, motor.session, motor.session_names);
  log.effort_column = "voltage_V";
  log.data.effort_unit = log.data.load_unit = "V";
  ActuatorRows& rows = log.data.rows;
  rows.effort = toArray(motor.voltage);
  rows.current = toArray(motor.current);
  rows.current_noise = noiseLevel(motor.current);
  rows.speed = toArray(motor.velocity);
  setDirection(motor.velocity, log);
  rows.current_rate = slopeOf(rows, rows.current, FrictionDataOptions::kDefaultBandwidth / rows.step);
  leaveOutJumps(rows.current_rate, log.data.keep);
  addOptional(table, log, {{"current", &rows.current}, {"velocity", &rows.speed}});
  return log;
}

}  // namespace

extern const LogKind entry;
const LogKind entry{.kind = ActuatorKind::kMotor,
                    .name = "motor",
                    .prepare = prepare,
                    .checks = FaultChecks::kLevels,
                    .answer = "current_A",
                    .answers = &ActuatorRows::current};

}  // namespace simgap::log_kinds::motor
