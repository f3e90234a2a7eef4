/// \file
/// Where an arm and its model part: faulty poses, errors against joints and order, torques that would close the gap.
#pragma once

#include <string>
#include <vector>

#include "pose_fit.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Poses that no physics explains: turned by a confusion of markers, or a copy of the pose before. \param fit  at its
/// solution on all poses
std::vector<DataFault> findPoseFaults(PoseFit& fit, double capture_sd, std::vector<bool>& faulty);

/// Squared joint error of each pose, mean over the joints [deg^2]; measured against the equilibrium next to it.
std::vector<double> squaredErrors(const ArmModel& model, std::span<const Pose> poses);

/// Weight of each pose by how precisely it can be known at all, mean 1: a pose that joint friction holds anywhere
/// within ten degrees must not drown the others. \param z  of the model without causes
std::vector<double> precisionWeights(const PoseProblem& problem, const Eigen::VectorXd& z, std::span<const Pose> poses);

/// Weighted mean squared error that remains for a right model: capture noise and what joint friction holds [deg^2].
double poseNoiseFloor(PoseFit& fit);

/// Mean errors over the order of the poses, the joints' positions and the muscles' tensions, before and after.
/// Of a muscle the error is what its tension would have to differ by to close the gap, least squares on the lever arms.
std::vector<EvidenceBin> poseEvidence(PoseFit& before, PoseFit& after);

/// Channels on which the whitened residual still depends, largest first: the share of its square that a parabola in the
/// channel explains beyond chance.
std::vector<Leftover> poseLeftovers(PoseFit& fit);

}  // namespace simgap
