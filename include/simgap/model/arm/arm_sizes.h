/// \file
/// How large an arm is, as multiples of the sample arm (data/arm): what an effect's sizes, stated for that arm, are
/// worth on a larger one. The sample arm with all forces times a factor has the same springs and friction.
#pragma once

#include "simgap/model/arm/arm.h"

namespace simgap {

/// What kind of size a number is.
enum class ArmSize {
  kNone,        ///< the same on every arm: angles, times, shares
  kLength,      ///< of levers, and speeds of what lengthens
  kTorque,      ///< and stiffnesses of joints
  kCompliance,  ///< strain per force
};

struct ArmSizes {
  double length = 1.0, force = 1.0;
  double of(ArmSize size) const;
};

/// From the model alone: lengths are the distances of lines' attachments from the nearest joint of their body, forces
/// what the cords pull with at a stretch of such a length, or, of an arm without, the weight of the bodies. What an arm
/// does not have, or has smaller, is as on the sample arm.
ArmSizes sizesOf(const ArmModel& model);

}  // namespace simgap
