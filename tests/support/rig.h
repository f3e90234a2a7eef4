/// \file
/// What a rig of tests/reality recorded, as the program reads it.
#pragma once

#include "reality/arm_rig.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/parameter_space.h"

namespace simgap::test {

/// A rig's hand-measured model and its recordings.
struct RecordedRig {
  ArmModel model;
  std::vector<Pose> calibration, validation;
};
RecordedRig recordRig(std::uint64_t seed, const reality::RigOptions& options = {});

/// One recorded pose.
Pose poseOf(const ArmModel& model, const reality::RecordedPose& recorded, const std::string& name);

/// The 99 parameters of configs/calibrate_arm.yaml with their priors.
ParameterSpace paperParameters(const ArmModel& model);

/// Mean joint errors of equilibria found from rest [deg], shape (joints).
std::vector<double> meanJointErrors(const ArmModel& model, std::span<const Pose> poses);

}  // namespace simgap::test
