/// \file
/// `design --drive`.
#pragma once

#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"

namespace simgap {

struct DriveDesignOptions {
  CommonOptions common;
  std::string limits;
  std::string model;  ///< of a fit; empty: the limits hold a guess
};
ExitCode designBench(const DriveDesignOptions& options, const std::vector<std::string>& argv);

}  // namespace simgap
