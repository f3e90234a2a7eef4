#include "shaft_position.h"

namespace simgap {

double ShaftPositionController::voltage(double command, const MuscleSensors& sensors) {
  return gain_ * (command - sensors.shaft);
}

}  // namespace simgap
