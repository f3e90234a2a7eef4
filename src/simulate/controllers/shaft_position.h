/// \file
/// P control of the shaft, V = K_p (phi_ref - phi) (000 section VII, "kite line length").
#pragma once

#include "simgap/simulate/muscle_controller.h"

namespace simgap {

class ShaftPositionController : public MuscleController {
 public:
  explicit ShaftPositionController(double gain) : gain_(gain) {}
  void reset() override {}
  double voltage(double command, const MuscleSensors& sensors) override;

 private:
  double gain_;  ///< [V/rad]
};

}  // namespace simgap
