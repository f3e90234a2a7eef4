// A drive's log: effort against load and motion.
#include "measure/logs/prepared_rows.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap::log_kinds::friction {

extern const LogKind entry;
const LogKind entry{.kind = ActuatorKind::kFriction,
                    .name = "friction",
                    .prepare = prepareDrive,
                    .checks = FaultChecks::kMotion,
                    .is_drive = true,
                    .at_joint = true};

}  // namespace simgap::log_kinds::friction
