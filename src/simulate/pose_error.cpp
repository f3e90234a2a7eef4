#include "simgap/simulate/pose_error.h"

#include <fmt/format.h>

#include <limits>

#include "simgap/core/joint_kind.h"

namespace simgap {

std::string_view toString(PoseObjective objective) { return objective == PoseObjective::kPaper ? "paper" : "geodesic"; }

Assessment assess(const PoseLayout& layout, std::span<const Pose> poses, std::span<const PoseOutcome> outcomes,
                  PoseObjective objective) {
  Assessment result;
  result.outcomes.assign(outcomes.begin(), outcomes.end());
  result.errors.resize(poses.size());
  result.mje.assign(layout.joints.size(), 0.0);
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (outcomes[p].status != PoseStatus::kSteady) continue;
    ++result.valid;
    for (std::size_t j = 0; j < layout.joints.size(); ++j) {
      const JointType type = layout.joints[j].type;
      const double error = jointError(type, poses[p].joints[j], outcomes[p].joints[j]);
      result.errors[p].push_back(error);
      result.mje[j] += error;
      const double printed = objective == PoseObjective::kPaper ? kindOf(type).printed_error : 1.0;
      const double counted = printed * kindOf(type).counted * error;
      result.fitness += counted * counted;
    }
  }
  for (double& mean : result.mje) mean /= static_cast<double>(result.valid);
  if (result.valid < poses.size()) result.fitness = std::numeric_limits<double>::quiet_NaN();
  return result;
}

std::string describe(const PoseOutcome& outcome, const PoseLayout& layout) {
  switch (outcome.status) {
    case PoseStatus::kAcquisitionError:
      return fmt::format("acquisition error of {}, {:.1f} deg", layout.muscles[outcome.worst],
                         toDegrees(outcome.worst_value));
    case PoseStatus::kNotSteady:
      return fmt::format("{} not steady, {:.3g} {}/s{}", layout.joints[outcome.worst].name,
                         outcome.worst_value / kindOf(layout.joints[outcome.worst].type).counted,
                         kindOf(layout.joints[outcome.worst].type).unit,
                         outcome.settle_needed > 0.0
                             ? fmt::format(", would rest within some {:.2g} s of settling", outcome.settle_needed)
                             : "");
    default:
      return std::string(toString(outcome.status));
  }
}

}  // namespace simgap
