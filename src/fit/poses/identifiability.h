/// \file
/// Which parameters only a combination of which can be known, said in words.
#pragma once

#include <vector>

#include "simgap/fit/poses/pose_uncertainty.h"

namespace simgap {

/// \param recorded  whitened Jacobian of the recorded poses, shape (any, parameters), per prior standard deviation
/// \param anywhere  the same of many more poses
/// \param[out] unknowable  shape (parameters): share of each prior variance that lies in directions without any effect
std::vector<Combination> findCombinations(const Eigen::MatrixXd& recorded, const Eigen::MatrixXd& anywhere,
                                          const ParameterSpace& space, Eigen::VectorXd& unknowable);

}  // namespace simgap
