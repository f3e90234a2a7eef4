/// \file
/// `design --excite`.
#pragma once

#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"

namespace simgap {

struct ExciteOptions {
  CommonOptions common;
  std::string robot, limits, gravity, law = "coulomb";
};
ExitCode designExcitation(const ExciteOptions& options, const std::vector<std::string>& argv);

}  // namespace simgap
