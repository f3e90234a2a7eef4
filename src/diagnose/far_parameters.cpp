#include "far_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace simgap {

std::vector<std::string> farParameters(const ScaledParameters& parameters, const ParameterSpace& space,
                                       const Eigen::VectorXd& z, Eigen::Index ordinary) {
  constexpr double kFar = 3.5;  // [sd] of the prior: one of 2000 lies further by chance
  std::vector<std::string> warnings;
  for (Eigen::Index i = 0; i < std::min(ordinary, parameters.size()); ++i) {
    if (!parameters.hasPrior(i) || std::abs(z[i]) <= kFar) continue;
    warnings.push_back(fmt::format(
        "{} lies {:.1f} standard deviations from its hand measurement: measure it again, or leave it out of "
        "the fitted parameters, and a cause that it stands for can be named",
        space.parameters()[static_cast<std::size_t>(i)].name, std::abs(z[i])));
  }
  return warnings;
}

}  // namespace simgap
