/// \file
/// `design --separate`.
#pragma once

#include "cli/log_intervention.h"
#include "simgap/intervene/motions/motion_separation.h"

namespace simgap {

struct SeparateOptions {
  InterveneOptions of;  ///< run, bench and profile
  std::size_t candidates = 300, count = 7;
  std::vector<double> speeds = {0.5, 1.0, 2.0}, loads = {0.5, 1.0, 2.0};
  MotionLimits limits = {};
};
/// \param app  the command: options that mean nothing to this diagnosis are refused
ExitCode designSeparation(const SeparateOptions& options, const std::vector<std::string>& argv, const CLI::App& app);

}  // namespace simgap
