#include "pose_self_test.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/random.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

constexpr double kAboveDetectable = 1.5;  // of the magnitude that the poses should reveal
constexpr std::uint32_t kNoisePurpose = 22, kTargetPurpose = 23;

/// The poses as a rig like this would record them of a model: equilibria, each moved by noise drawn from the covariance
/// that whitens it. A pose without an equilibrium is left out.
PoseSet simulatePoses(const ArmModel& model, PoseFit& fit, std::uint64_t seed) {
  const std::span<const Pose> poses = fit.posterior().poses();
  EquilibriumArm arm(model);
  const CounterRandom random(seed);
  PoseSet set{"self-test", {}};
  for (std::size_t p = 0; p < poses.size(); ++p) {
    Pose pose = poses[p];
    arm.setHistory(pose.time, pose.shafts_before);
    if (!arm.solveFrom(pose.joints, pose.shafts).stable) continue;
    pose.joints = arm.observe(pose.shafts, pose.shafts_before);
    Eigen::VectorXd noise(fit.posterior().degreesOfFreedom());
    for (Eigen::Index i = 0; i < noise.size(); ++i) {
      noise[i] = random.normalPair({static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(i), 0, kNoisePurpose})[0];
    }
    noise = inverse(fit.posterior().whitening(p)) * noise;
    Eigen::Index d = 0;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      if (!model.joints[j].hasAxis()) {
        pose.joints[j].rotation = (pose.joints[j].rotation * expSo3(noise.segment<3>(d))).normalized();
      } else {
        pose.joints[j].angle += noise[d];
      }
      d += model.joints[j].degreesOfFreedom();
    }
    set.poses.push_back(std::move(pose));
  }
  return set;
}

std::string answerOf(const Diagnosis& diagnosis, const std::string& hidden, const std::string& label) {
  if (diagnosis.causes.empty() || diagnosis.verdict == DiagnosisVerdict::kUnexplained) {
    return diagnosis.verdict == DiagnosisVerdict::kNothingFound ? "none" : std::string(toString(diagnosis.verdict));
  }
  const Cause& first = diagnosis.causes.front();
  if (first.ambiguous_with.empty()) {
    const bool right = effectLabel(first.effect, first.target) == label;
    return right || first.effect != hidden ? first.effect : first.effect + " elsewhere";
  }
  return "ambiguous";
}

/// Whether an answer to poses in which nothing was hidden is no false alarm.
bool isQuiet(const std::string& answer) {
  const ArmEffect* named = findArmEffect(answer);
  return answer == "none" || answer == "unexplained" || (named != nullptr && named->in_every_joint);
}

/// Puts one of the targets into the model, larger than what the poses should reveal. \returns its label
std::string hideOne(const std::vector<const Detectable*>& targets, const std::vector<ArmHypothesis>& hypotheses,
                    PoseFit& fit, std::uint64_t seed, ArmModel& model) {
  const double u = CounterRandom(seed).uniform({0, 0, 0, kTargetPurpose});
  const Detectable& d = *targets[static_cast<std::size_t>(u * static_cast<double>(targets.size()))];
  const auto h = std::ranges::find_if(hypotheses, [&](const ArmHypothesis& other) {
    return other.effect->name == d.effect && other.target == d.target;
  });
  EffectParameters p = h->starts.front();
  p[0] = kAboveDetectable * d.magnitude95;
  if (h->effect->from_moment) {
    const std::span<const Pose> poses = fit.posterior().poses();
    p[1] = poses[poses.size() / 2].time;
  }
  model.extensions.push_back(makeExtension(*h->effect, d.target, p));
  return effectLabel(h->effect->name, d.target);
}

}  // namespace

SelfTest selfTestPoses(const PoseProblem& problem, PoseFit& fit, const std::vector<ArmHypothesis>& hypotheses,
                       const std::vector<Detectable>& detectable, const PoseDiagnosisOptions& options,
                       const DiagnosisProgress& progress) {
  SelfTest test;
  test.hidden = {"none"};
  test.answers = {"none", "ambiguous", "unexplained", "data-fault"};
  for (const ArmHypothesis& h : hypotheses) {
    const std::string name(h.effect->name);
    if (std::ranges::find(test.hidden, name) != test.hidden.end()) continue;
    test.hidden.push_back(name);
    test.answers.push_back(name);
    test.answers.push_back(name + " elsewhere");
  }
  test.count.assign(test.hidden.size(), std::vector<int>(test.answers.size(), 0));
  PoseDiagnosisOptions inner = options;
  inner.self_test = 0;
  PoseProblem truth = problem;
  truth.nominal = fit.model();
  const std::size_t total = test.hidden.size() * static_cast<std::size_t>(options.self_test);
  /// What one diagnosis calls a hidden cause; empty: there is no target to hide it in.
  const auto runOne = [&](std::size_t i) -> std::string {
    const std::size_t e = i / static_cast<std::size_t>(options.self_test);
    const std::size_t n = i % static_cast<std::size_t>(options.self_test);
    progress("self-test: " + test.hidden[e], static_cast<double>(i) / static_cast<double>(total));
    std::vector<const Detectable*> targets;
    for (const Detectable& d : detectable) {
      if (d.effect == test.hidden[e]) targets.push_back(&d);
    }
    const std::uint64_t seed = options.seed + 1000 * e + n + 1;
    if (e > 0 && targets.empty()) return {};
    ArmModel model = truth.nominal;
    const std::string label = e > 0 ? hideOne(targets, hypotheses, fit, seed, model) : "";
    const PoseSet set = simulatePoses(model, fit, seed);
    const auto silent = [](const std::string&, double) {};
    const PoseDiagnosis answer = diagnosePoses(problem.nominal, set, problem.parameters, problem.noise, inner, silent);
    return answerOf(answer.diagnosis, test.hidden[e], label);
  };
  std::vector<std::string> names(total);
  computeOnRanks(std::span(names), runOne, /*one_by_one=*/true);
  stopIfInterrupted();
  int right = 0;
  for (std::size_t e = 0; e < test.hidden.size(); ++e) {
    for (std::size_t n = 0; n < static_cast<std::size_t>(options.self_test); ++n) {
      const std::string& name = names[e * static_cast<std::size_t>(options.self_test) + n];
      if (name.empty()) continue;
      const auto column = std::ranges::find(test.answers, name) - test.answers.begin();
      if (column < std::ssize(test.answers)) ++test.count[e][column];
      if (e == 0) test.false_alarm_rate += isQuiet(name) ? 0.0 : 1.0 / options.self_test;
      if (e > 0 && name == test.hidden[e]) ++right;
    }
  }
  if (test.hidden.size() > 1) {
    test.power = right / (static_cast<double>(test.hidden.size() - 1) * options.self_test);
  }
  return test;
}

}  // namespace simgap
