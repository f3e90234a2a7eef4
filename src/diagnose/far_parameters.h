/// \file
/// Parameters that poses or motions put far from where they were measured by hand.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/fit/poses/pose_posterior.h"

namespace simgap {

/// A warning each: what is wrong there may be a cause that no other can be named beside, or one that the fit takes up
/// so well that nothing it has not seen is missed. \param z  of the fit [sd of the priors]; \param ordinary  so many of
/// them, the first, are no cause's
std::vector<std::string> farParameters(const ScaledParameters& parameters, const ParameterSpace& space,
                                       const Eigen::VectorXd& z, Eigen::Index ordinary);

}  // namespace simgap
