// A log of a motor with a gearbox on a bench, whose voltages and loads are often stepped.
#include "measure/logs/prepared_rows.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap::log_kinds::gearbox {
namespace {

PreparedLog prepare(const CsvTable& table, const Bench& bench, const FrictionDataOptions& options) {
  PreparedLog log = prepareDrive(table, bench, options);
  log.kind = ActuatorKind::kGearbox;
  // Without the ratio a position is the motor's, and a ripple of every turn would be a weight at the joint.
  if (!bench.ratio && !table.has("joint_position_rad")) log.data.rows.joint_angle.resize(0);
  leaveOutJumps(log.data.rows.acceleration, log.data.keep);
  return log;
}

}  // namespace

extern const LogKind entry;
const LogKind entry{.kind = ActuatorKind::kGearbox,
                    .name = "gearbox",
                    .prepare = prepare,
                    .checks = FaultChecks::kMotion,
                    .is_drive = true,
                    .law = "coulomb",
                    .effect = "inertia"};

}  // namespace simgap::log_kinds::gearbox
