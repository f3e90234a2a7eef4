/// \file
/// The most probable parameters by Levenberg-Marquardt (Ceres) with the equilibria's own derivatives.
#pragma once

#include <Eigen/Core>

#include "simgap/core/bytes.h"
#include "simgap/fit/poses/pose_posterior.h"

namespace simgap {

struct PosteriorFit {
  Eigen::VectorXd z;
  double objective = 0.0;  ///< negative log posterior; infinite: no stable equilibrium was found for some pose
  int iterations = 0;
  long evaluations = 0;  ///< poses solved
};

/// Between ranks.
inline void pack(Bytes& bytes, const PosteriorFit& fit) {
  pack(bytes, fit.z);
  pack(bytes, fit.objective);
  pack(bytes, fit.iterations);
  pack(bytes, fit.evaluations);
}
inline void unpack(BytesReader& from, PosteriorFit& fit) {
  unpack(from, fit.z);
  unpack(from, fit.objective);
  unpack(from, fit.iterations);
  unpack(from, fit.evaluations);
}

/// Descends from z to the next local minimum, within the parameters' bounds. After an interrupt it is not there yet.
/// \param tolerance  ends where a step changes the objective by less than this fraction
PosteriorFit descendPosterior(PosePosterior& posterior, const Eigen::VectorXd& z, int max_iterations = 60,
                              double tolerance = 1e-7);

/// A start near the measured poses that needs no equilibrium: parameters that balance all torques there, demanded ever
/// more strictly (20 deg to 0.6 deg of what a torque would move the joints).
Eigen::VectorXd balanceTorques(PosePosterior& posterior, const Eigen::VectorXd& z);

}  // namespace simgap
