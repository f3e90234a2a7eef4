/// \file
/// The command is the voltage.
#pragma once

#include "simgap/simulate/muscle_controller.h"

namespace simgap {

class OpenLoopController : public MuscleController {
 public:
  void reset() override {}
  double voltage(double command, const MuscleSensors& sensors) override;
};

}  // namespace simgap
