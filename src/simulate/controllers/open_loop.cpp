#include "open_loop.h"

namespace simgap {

double OpenLoopController::voltage(double command, const MuscleSensors&) { return command; }

}  // namespace simgap
