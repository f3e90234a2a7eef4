#include "pose_candidates.h"

#include <algorithm>

namespace simgap {
namespace {

bool holds(const std::vector<ArmCause>& causes, const ArmCause& cause) {
  return std::ranges::find(causes, cause.label(), &ArmCause::label) != causes.end();
}

CandidateModel candidateOf(PoseFit& fit, const char* role, double stray) {
  return {labelOf(fit.causes()), role, fit.logEvidence(), fit.model(), stray};
}

}  // namespace

std::vector<CandidateModel> candidateModels(const PoseProblem& problem, PoseFit& plain, double stray_plain,
                                            PoseFit& fit, const PoseSelection& selection) {
  const std::span<const Pose> poses = fit.posterior().poses();
  struct Other {
    std::vector<ArmCause> causes;
    Eigen::VectorXd z;  ///< of all but the last
    const char* role;
  };
  std::vector<Other> others;
  for (std::size_t c = 0; c < selection.causes.size(); ++c) {
    const std::vector<ArmCause> kept = withoutOne(fit.causes(), c);
    for (const ArmCause& instead : selection.causes[c].instead) {
      others.push_back({withOneMore(kept, instead), fit.solutionWithout(c), "instead"});
    }
  }
  // Each of several alone: what was named beside the true cause must not stand in all models that a change is to judge.
  for (const ArmCause& cause : fit.causes()) {
    if (fit.causes().size() > 1) others.push_back({{cause}, plain.z(), "alone"});
  }
  for (const ArmCause& refused : selection.refused) {
    if (!holds(fit.causes(), refused)) others.push_back({withOneMore(fit.causes(), refused), fit.z(), "refused"});
  }
  std::vector<CandidateModel> candidates(others.size());
  forEach(problem, others.size(), [&](std::size_t i) {
    PoseFit other = fittedFrom(problem, poses, others[i].causes, others[i].z);
    candidates[i] = candidateOf(other, others[i].role, problem.stray_friction);
  });
  std::erase_if(candidates, [](const CandidateModel& candidate) { return !std::isfinite(candidate.log_odds); });
  candidates.insert(candidates.begin(), candidateOf(fit, "named", problem.stray_friction));
  if (!fit.causes().empty()) candidates.push_back(candidateOf(plain, "without", stray_plain));
  const double named = candidates.front().log_odds;
  for (CandidateModel& candidate : candidates) candidate.log_odds -= named;
  return candidates;
}

void dropNamedRivals(PoseSelection& selection) {
  for (AcceptedCause& accepted : selection.causes) {
    std::erase_if(selection.candidates, [&own = accepted.cause](const Candidate& candidate) {
      return candidate.effect == own.effect->name && candidate.target == own.target;
    });
    for (const AcceptedCause& other : selection.causes) {
      const std::string named = other.cause.label();
      std::erase(accepted.rivals, named);
      std::erase_if(accepted.instead, [&](const ArmCause& cause) { return cause.label() == named; });
    }
  }
}

}  // namespace simgap
