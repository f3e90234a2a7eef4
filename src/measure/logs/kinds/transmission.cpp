// Between the two angles of a drive: the joint's explained by the motor's.
#include "simgap/measure/logs/log_kind.h"

namespace simgap {
namespace log_kinds::transmission {

extern const LogKind entry;
const LogKind entry{
    .kind = ActuatorKind::kTransmission, .name = "transmission", .prepare = nullptr, .checks = FaultChecks::kMotion};

}  // namespace log_kinds::transmission

PreparedLog prepareTransmissionData(const PreparedLog& drive) {
  PreparedLog log = drive;
  log.kind = ActuatorKind::kTransmission;
  log.effort_column = "joint_position_rad";
  log.data.effort_unit = "rad";
  log.data.rig.resize(log.data.rows.rows(), 0);
  log.data.rig_parameters.clear();
  log.data.angle.reset();
  log.data.rows.effort = log.data.rows.joint_angle;
  log.context.clear();
  log.data.rows.context.clear();
  return log;
}

}  // namespace simgap
