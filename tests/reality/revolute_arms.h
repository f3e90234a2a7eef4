/// \file
/// Arms that users build: joints that are all hinges, one to eight of them.
#pragma once

#include "reality/arm_statics.h"

namespace simgap::reality {

/// Shoulder of two hinges (flexion, twist) and elbow; eleven muscles, one of them over two joints.
Arm threeHingeArm();
/// Shoulder and elbow in one plane; six muscles, two of them over both joints.
Arm planarArm();
/// One hinge and its two muscles.
Arm oneHingeArm();
/// Eight short links with crossed hinges, two muscles each.
Arm eightHingeArm();

}  // namespace simgap::reality
