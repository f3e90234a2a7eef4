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

/// Poses that the model of a fit has no rest downhill of where they were measured, shape (poses): it sees another
/// branch there, or none, and what small changes of it do to them says nothing of causes.
std::vector<bool> posesWithoutRest(const PoseFit& fit, std::span<const Pose> poses);

/// Squared joint errors of poses, each counted by how precisely a model can predict it at all: by the noise and by what
/// is not known of the parameters, both much larger where an arm is soft. Beyond some 6 sd they count ever less, as in
/// the fits; poses that cannot be told within ten degrees are left out.
class PoseErrors {
 public:
  /// \param fit  without causes, at its solution on the poses of the selection \param poses  must outlive it
  PoseErrors(const PoseProblem& problem, PoseFit& fit, std::span<const Pose> poses);
  /// Shape (poses that count) [deg^2].
  Eigen::ArrayXd of(const ArmModel& model) const;

 private:
  std::span<const Pose> poses_;
  std::vector<double> variances_;  ///< shape (poses) [deg^2]
  std::size_t counted_ = 0;
  double typical_ = 0.0;  ///< harmonic mean of those that count
};

/// Weighted mean squared error that remains for a right model: capture noise and what joint friction holds [deg^2].
double poseNoiseFloor(PoseFit& fit);

/// Mean errors over the order of the poses, the joints' positions and the muscles' tensions, before and after.
/// Of a muscle the error is what its tension would have to differ by to close the gap, least squares on the lever arms.
std::vector<EvidenceBin> poseEvidence(PoseFit& before, PoseFit& after);

/// Channels on which the whitened residual still depends, largest first: the share of its square that a parabola in the
/// channel explains beyond chance.
std::vector<Leftover> poseLeftovers(PoseFit& fit);

}  // namespace simgap
