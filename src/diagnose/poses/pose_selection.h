/// \file
/// Which causes the poses speak for: greedy forward steps over all hypotheses, each a refit of the whole model, then
/// exchange of causes for rivals, then backward pruning.
#pragma once

#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "pose_fit.h"
#include "pose_hypotheses.h"

namespace simgap {

/// A hypothesis after its best refit.
struct PoseCandidate {
  ArmCause cause;           ///< with the choices that fitted best
  Eigen::VectorXd z;        ///< of the whole model with it
  double odds = 0.0;        ///< log of the odds against the model without it
  double likelihood = 0.0;  ///< objective that it saves
  double share = 1.0;       ///< of all hypotheses, before any data
};

struct AcceptedCause {
  ArmCause cause;
  double odds = 0.0;  ///< log, against the model without it
  double p_adjusted = 1.0;
  Interval gain_inner;
  std::vector<std::string> rivals;     ///< that these poses do not tell from it
  std::set<std::string> contenders;    ///< that an exchange tries in its place
  std::vector<ArmCause> instead = {};  ///< what fitted best in its place: the rivals, then others, best first
};

struct PoseSelection {
  std::vector<AcceptedCause> causes;
  Eigen::VectorXd z;                      ///< of the model with them, on the poses of the selection
  Eigen::VectorXd z_plain;                ///< without
  double stray = 1.0, stray_plain = 1.0;  ///< PoseProblem::stray_friction with the causes and without
  std::vector<HypothesisRecord> records;
  std::vector<ArmCause> refused;      ///< the best of the last step, which accepted none
  std::vector<Candidate> candidates;  ///< that the poses speak for, with why they are no causes
  bool tethered = false;              ///< something pulls that would show if it were the base that is off level
  std::vector<std::string> left_out;  ///< poses near which a model with the causes has no rest
  double excess = 0.0;     ///< of the cross-validated squared distances over what the final model expects, a fraction
  double excess_sd = 0.0;  ///< of that under the model
  double excess_plain = 0.0;

  /// The first so many of the causes, as a fit takes them.
  std::vector<ArmCause> firstCauses(std::size_t count) const {
    std::vector<ArmCause> first;
    for (const AcceptedCause& accepted : std::span(causes).first(count)) first.push_back(accepted.cause);
    return first;
  }
  std::vector<ArmCause> allCauses() const { return firstCauses(causes.size()); }
};

PoseSelection selectCauses(const PoseProblem& problem, std::span<const Pose> poses,
                           const std::vector<ArmHypothesis>& hypotheses, const Eigen::VectorXd& start,
                           const PoseDiagnosisOptions& options, const std::function<void(std::string_view)>& stage);

}  // namespace simgap
