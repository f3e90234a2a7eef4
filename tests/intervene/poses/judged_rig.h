/// \file
/// A drawn arm of the independent statics with the models of some causes, as a diagnosis leaves them.
#pragma once

#include <string>
#include <vector>

#include "diagnose/poses/pose_rig.h"
#include "diagnose/poses/pose_selection.h"
#include "simgap/intervene/poses/pose_intervention.h"

namespace simgap::test {

/// A drawn arm with the models of some causes, each fitted to its poses; the first is the one that was named.
struct Judged {
  PoseRig rig;
  PoseEvidence evidence;

  Judged(std::uint64_t seed, const reality::PoseDrawOptions& options, const std::vector<std::string>& causes)
      : rig(seed, options) {
    evidence = {rig.problem.nominal, rig.problem.parameters, rig.problem.noise, rig.set.poses, {}, 0.0, 0};
    for (const std::string& cause : causes) evidence.candidates.push_back(fitted(cause));
    const double named = evidence.candidates[0].log_odds;
    for (CandidateModel& candidate : evidence.candidates) candidate.log_odds -= named;
  }

  CandidateModel fitted(const std::string& label) {
    CandidateModel best{label, "instead", -1e300, {}, 1.0};
    std::vector<NotTestable> none;
    std::vector<ArmCause> causes;
    for (const ArmHypothesis& h : poseHypotheses(rig.problem.nominal, rig.set.poses, {}, none)) {
      if (labelOf(h.effect->name.data(), h.target) != label) continue;
      for (const EffectParameters& start : h.starts) causes.push_back({h.effect, h.target, start});
    }
    const auto consider = [&](std::vector<ArmCause> chosen) {
      PoseFit fit(rig.problem, rig.set.poses, std::move(chosen));
      fit.posterior().whitenLike(rig.plain.posterior());
      fit.descend(fit.extended(rig.plain.z()));
      if (fit.logEvidence() > best.log_odds) best = {label, "instead", fit.logEvidence(), fit.model(), 1.0};
    };
    if (causes.empty()) consider({});
    for (const ArmCause& cause : causes) consider({cause});
    return best;
  }

  Intervention judge(const std::string& yaml) const { return judgeChange(evidence, changeOf(yaml), after()); }
  ArmChanges changeOf(const std::string& yaml) const {
    return ArmChanges::read(YamlNode::parse("format: simgap/change/1\nchanges:\n" + yaml, "change.yaml"),
                            evidence.given);
  }
  PoseSet after() const { return posesOf(rig.draw, rig.draw.fresh); }
};

/// A seed whose payload hangs on the forearm, which the draw leaves open.
inline std::uint64_t seedOfAForearm() {
  for (std::uint64_t seed = 1;; ++seed) {
    if (reality::drawPoses(seed, {.poses = 1, .effect = "payload"}).hidden[0].target == "link2") return seed;
  }
}

}  // namespace simgap::test
