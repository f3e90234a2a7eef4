/// \file
/// What a calibration found, and the judgement of a model on pose sets.
#pragma once

#include <limits>
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

/// Mean joint errors before and after over the same poses: those steady with both models; `after` stands alone where no
/// pose was steady before.
struct ComparedErrors {
  std::size_t poses = 0;              ///< that they are means of
  std::vector<double> before, after;  ///< shape (joints) [rad]; NaN: none
};
ComparedErrors compareErrors(const SetResult& set, std::size_t joints);

struct CalibrationResult {
  PoseLayout layout;
  std::vector<SetResult> sets;  ///< calibration first; validation when it was given
  std::vector<SearchParameter> parameters;
  CalibrationState state;
  CalibrationConfig config;

  /// How far the parameters found are from the most probable ones [sd]; NaN: no pose has a stable equilibrium.
  double from_optimum = std::numeric_limits<double>::quiet_NaN();
  std::optional<PoseUncertainty> uncertainty = {};  ///< only of the most probable parameters, see kAtOptimum
  PredictedError predicted_unseen =
      {};  ///< of commands like the recorded ones; empty without uncertainty or such commands
};

/// What of a result can be given to the user.
struct Delivery {
  bool calibrated = true;  ///< false: it is worse than the start, which is kept
  std::string failure;     ///< why the run failed, a sentence; empty: it did not
};

/// A result is worse than the start when on a set fewer poses are steady, or the mean joint error over the poses steady
/// with both has grown. It fails, too, when one of its poses is not steady.
Delivery judgeDelivery(const CalibrationResult& result);

/// Distance of the final poses that the two evaluators found, of one joint, over the poses valid for both [rad].
struct PoseDifference {
  double mean = 0.0;
  double largest = 0.0;
};
PoseDifference poseDifference(const SetResult& set, const PoseLayout& layout, std::size_t joint);

/// What the calibration poses tell of the parameters at `values` (fills from_optimum, and uncertainty and predictions
/// at the optimum). \param model  as the calibration began
void addUncertainty(const ArmModel& model, const ParameterSpace& space, std::span<const double> values,
                    CalibrationResult& result);

}  // namespace simgap
