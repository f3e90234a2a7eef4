/// \file
/// What a calibration found, and the judgement of a model on pose sets.
#pragma once

#include <string>
#include <vector>

#include "simgap/fit/calibration.h"

namespace simgap {

/// A pose set judged before and after.
struct SetResult {
  std::string name;  ///< "calibration" or "validation"
  PoseSet set;
  Assessment initial;  ///< of the unmutated model
  Assessment final;    ///< of I_best
};

struct CalibrationResult {
  PoseLayout layout;
  std::vector<SetResult> sets;  ///< calibration first; validation when it was given
  std::vector<SearchParameter> parameters;
  CalibrationState state;
  CalibrationConfig config;

  long evaluations() const {
    return static_cast<long>(state.strategy.generation) * config.strategy.lambda *
           static_cast<long>(sets.front().set.poses.size());
  }
};

}  // namespace simgap
