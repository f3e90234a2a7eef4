/// \file
/// Between the judge of statics (reality/arm_statics.h) and the simulation: models, poses, angles.
#pragma once

#include <span>
#include <vector>

#include "reality/arm_statics.h"
#include "simgap/simulate/pose_protocol.h"

namespace simgap::test {

/// The arm as its model file reads.
ArmModel modelOf(const reality::Arm& arm, bool joint_coulomb);

/// Positions of the joints as the judge counts them.
reality::Configuration configurationOf(const reality::Arm& arm, std::span<const JointPosition> joints);

/// Largest rotation of a joint between the two [rad].
double largestAngle(const reality::Arm& arm, const reality::Configuration& a, const reality::Configuration& b);

/// The paper's protocol with an end so slow that what is left of the motion does not count.
PoseProtocol patientProtocol(double max_velocity);

}  // namespace simgap::test
