/// \file
/// What a calibration found, and the judgement of a model on pose sets.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/pose_uncertainty.h"

namespace simgap {

/// A pose set judged before and after.
struct SetResult {
  std::string name;  ///< "calibration" or "validation"
  PoseSet set;
  Assessment initial;  ///< of the unmutated model
  Assessment final;    ///< of I_best
  /// `final` as the evaluator that searched sees it, where another one judged.
  std::optional<Assessment> searched = {};
  /// Mean joint error that the posterior predicted for these poses; of poses that were fitted it says nothing.
  std::optional<PredictedError> predicted = {};
};

struct CalibrationResult {
  PoseLayout layout;
  std::vector<SetResult> sets;  ///< calibration first; validation when it was given
  std::vector<SearchParameter> parameters;
  CalibrationState state;
  CalibrationConfig config;

  std::optional<PoseUncertainty> uncertainty = {};  ///< none when no pose has a stable equilibrium
  PredictedError predicted_unseen = {};             ///< of commands like the recorded ones; empty without uncertainty
};

/// Distance of the final poses that the two evaluators found, of one joint, over the poses valid for both [rad].
struct PoseDifference {
  double mean = 0.0;
  double largest = 0.0;
};
PoseDifference poseDifference(const SetResult& set, const PoseLayout& layout, std::size_t joint);

/// What the calibration poses tell of the parameters at `values` (fills uncertainty and predictions).
/// \param model  as the calibration began
void addUncertainty(const ArmModel& model, const ParameterSpace& space, std::span<const double> values,
                    CalibrationResult& result);

}  // namespace simgap
