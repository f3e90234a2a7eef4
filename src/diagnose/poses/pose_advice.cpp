#include "pose_advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/fit/poses/pose_uncertainty.h"

namespace simgap {
namespace {

constexpr std::size_t kCandidates = 150;
constexpr std::size_t kManyPoses = 40;  // enough to name most causes (docs/diagnose.md)

/// The model with a rival in the place of the cause it is not told from.
PoseFit withRival(const PoseProblem& problem, PoseFit& fit, const std::string& cause, const std::string& rival,
                  const std::vector<ArmHypothesis>& hypotheses) {
  const auto replaced =
      static_cast<std::size_t>(std::ranges::find(fit.causes(), cause, &ArmCause::label) - fit.causes().begin());
  const Eigen::VectorXd z = fit.solutionWithout(replaced);
  const std::vector<ArmCause> causes = withoutOne(fit.causes(), replaced);
  PoseFit best(problem, fit.posterior().poses(), causes);
  double lowest = std::numeric_limits<double>::infinity();
  for (const ArmHypothesis& h : hypotheses) {
    if (h.label() != rival) continue;
    for (const EffectParameters& start : h.starts) {
      PoseFit other(problem, fit.posterior().poses(), withOneMore(causes, {h.effect, h.target, start}));
      other.posterior().whitenLike(fit.posterior());
      other.descend(other.extended(z));
      if (other.objective() >= lowest) continue;
      lowest = other.objective();
      best = std::move(other);
    }
  }
  return best;
}

/// The command at which two models part most, in words.
std::string partingPose(PoseFit& fit, PoseFit& other) {
  const ArmModel one = fit.model(), two = other.model();
  EquilibriumArm arm_one(one), arm_two(two);
  const double end = fit.posterior().poses().back().time;
  const Pose* best = nullptr;
  double farthest = 0.0;
  std::size_t joint = 0;
  const std::vector<Pose> commands = drawCommands(fit.posterior(), fit.z(), kCandidates, 11);
  for (const Pose& command : commands) {
    arm_one.setHistory(end);
    arm_two.setHistory(end);
    if (!arm_one.solve(command.shafts).stable) continue;
    const std::vector<JointPosition> seen = arm_one.observe(command.shafts, {});
    if (!arm_two.solveFrom(seen, command.shafts).stable) continue;
    const std::vector<JointPosition>& other_seen = arm_two.observe(command.shafts, {});
    for (std::size_t j = 0; j < seen.size(); ++j) {
      const JointKind& kind = kindOf(one.joints[j].type);
      const double apart = kind.counted * jointError(kind.type, seen[j], other_seen[j]);
      if (apart <= farthest) continue;
      farthest = apart;
      best = &command;
      joint = j;
    }
  }
  if (!best) return "";
  std::string shafts;
  for (std::size_t m = 0; m < one.muscles.size(); ++m) {
    shafts += fmt::format("{}{} {:.2f}", shafts.empty() ? "" : ", ", one.muscles[m].name, best->shafts[m]);
  }
  if (!shafts.empty()) shafts = "the shafts at " + shafts + " rad";
  const std::vector<CommandChannel> lines = one.poseLayout().lines;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    shafts += fmt::format("{}{} at {:.4g} {}", shafts.empty() ? "" : ", ", lines[k].stem,
                          best->shafts[one.muscles.size() + k], lines[k].unit);
  }
  const JointKind& kind = kindOf(one.joints[joint].type);
  return fmt::format("record the pose with {}: there the two differ by {:.1f} {} at the {}.", shafts,
                     kind.shown(farthest / kind.counted), kind.error_unit, one.joints[joint].name);
}

}  // namespace

std::string nextPoseExperiment(const PoseProblem& problem, PoseFit& fit, const PoseSelection& selection,
                               const std::vector<ArmHypothesis>& hypotheses,
                               const std::vector<NotTestable>& not_testable) {
  for (const AcceptedCause& accepted : selection.causes) {
    if (accepted.rivals.empty()) continue;
    const std::string cause = accepted.cause.label();
    PoseFit other = withRival(problem, fit, cause, accepted.rivals.front(), hypotheses);
    const std::string_view separates = accepted.cause.effect->separates_by;
    const std::string pose = std::isfinite(other.objective()) ? partingPose(fit, other) : "";
    return fmt::format("To tell {} from {}: {}. {}", cause, accepted.rivals.front(), separates,
                       pose.empty() ? "" : "Or " + pose);
  }
  if (!selection.causes.empty()) {
    return fmt::format("To confirm {}: {}.", selection.causes.front().cause.label(),
                       selection.causes.front().cause.effect->separates_by);
  }
  const std::size_t poses = fit.posterior().poses().size();
  if (poses < kManyPoses) {
    return fmt::format("Record {} poses or more, spread over the range of every joint: {} reveal large effects only.",
                       2 * kManyPoses, poses);
  }
  for (const NotTestable& effect : not_testable) {
    return fmt::format("Record time_s with every pose: {} cannot be tested without.", effect.effect);
  }
  return "Repeat a few commands from both sides and at the end of the session: that shows stiction and drift, and the "
         "noise without a model.";
}

}  // namespace simgap
