/// \file
/// The same arm with stronger forces: it rests where it rested.
#pragma once

#include "simgap/model/arm/arm.h"

namespace simgap::test {

/// Masses, inertias, cords, springs, dampers and frictions of joints times a factor; of arms without other tendons.
inline ArmModel withForces(ArmModel arm, double factor) {
  for (Body& body : arm.bodies) {
    for (Part& part : body.parts) {
      part.mass *= factor;
      part.inertia *= factor;
    }
  }
  for (Joint& joint : arm.joints) {
    joint.coulomb_friction *= factor;
    joint.viscous_friction *= factor;
    joint.spring_stiffness *= factor;
  }
  for (Muscle& muscle : arm.muscles) {
    muscle.shock_cord.stiffness *= factor;
    muscle.shock_cord.damping *= factor;
  }
  return arm;
}

}  // namespace simgap::test
