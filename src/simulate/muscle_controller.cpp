#include "simgap/simulate/muscle_controller.h"

#include "controllers/open_loop.h"
#include "controllers/shaft_position.h"

namespace simgap {

std::unique_ptr<MuscleController> makeController(CommandKind kind, const Muscle&, const ControllerOptions& options) {
  switch (kind) {
    case CommandKind::kSetpoint:
      return std::make_unique<ShaftPositionController>(options.shaft_gain);
    case CommandKind::kVoltage:
    case CommandKind::kForce:
      break;
  }
  return std::make_unique<OpenLoopController>();
}

}  // namespace simgap
