#include "simgap/fit/poses/calibration_result.h"

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {

PoseDifference poseDifference(const SetResult& set, const PoseLayout& layout, std::size_t joint) {
  PoseDifference difference;
  int poses = 0;
  for (std::size_t p = 0; p < set.set.poses.size(); ++p) {
    const PoseOutcome& judged = set.final.outcomes[p];
    const PoseOutcome& searched = set.searched->outcomes[p];
    if (judged.status != PoseStatus::kSteady || searched.status != PoseStatus::kSteady) continue;
    const double distance = jointError(layout.joints[joint].type, judged.joints[joint], searched.joints[joint]);
    difference.mean += distance;
    difference.largest = std::max(difference.largest, distance);
    ++poses;
  }
  difference.mean /= poses;  // NaN when there is none
  return difference;
}

void addUncertainty(const ArmModel& model, const ParameterSpace& space, std::span<const double> values,
                    CalibrationResult& result) {
  constexpr std::size_t kUnseen = 200;
  const PoseSet& recorded = result.sets.front().set;
  PosePosterior posterior(model, recorded.poses, space, result.config.noise);
  const Eigen::VectorXd z = posterior.parameters().scaled(values);
  posterior.whiten(z);
  try {
    result.uncertainty = assessUncertainty(posterior, z, space);
  } catch (const NumericsError&) {
    return;  // the model is nowhere at rest; its poses are reported as invalid
  }
  for (std::size_t s = 1; s < result.sets.size(); ++s) {
    result.sets[s].predicted = predictError(posterior, z, *result.uncertainty, result.sets[s].set.poses);
  }
  // A set of as many poses as were recorded: the interval is that of a mean over so many.
  std::vector<Pose> unseen = drawCommands(posterior, z, kUnseen, 1);
  if (unseen.size() > recorded.poses.size()) unseen.resize(recorded.poses.size());
  result.predicted_unseen = predictError(posterior, z, *result.uncertainty, unseen);
}

}  // namespace simgap
