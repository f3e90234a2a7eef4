#include "pose_selection.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "pose_score.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr std::size_t kFolds = 5;
constexpr double kClearOdds = 2.0;      // log odds, after paying for the number of hypotheses, that a cause must reach
constexpr double kTellApart = 3.5;      // log odds between two causes below which the poses do not tell them apart
constexpr double kSmallestGain = 0.01;  // of the error on poses a fit has not seen
constexpr double kTryTolerance = 3e-5;  // of the objective, some 0.01: far below what decides
constexpr double kHopeless = 30.0;    // log odds behind a step's best, beyond which no exchange will bring a rival back
constexpr double kSameMinimum = 0.3;  // objectives nearer than this belong to one minimum
constexpr int kBetterBases = 3;
constexpr std::size_t kFewPoses = 30;
constexpr std::size_t kTried = 6;  // candidates of a step that are cross-validated until one passes
constexpr std::uint32_t kBootstrapPurpose = 21;

struct Fold {
  std::vector<Pose> training, validation;
  std::vector<std::size_t> validation_index;
};

std::vector<Fold> interleavedFolds(std::span<const Pose> poses) {
  std::vector<Fold> folds(kFolds);
  for (std::size_t p = 0; p < poses.size(); ++p) {
    for (std::size_t f = 0; f < kFolds; ++f) {
      (p % kFolds == f ? folds[f].validation : folds[f].training).push_back(poses[p]);
    }
    folds[p % kFolds].validation_index.push_back(p);
  }
  return folds;
}

/// Squared distances of poses from fits to the others.
struct CrossValidation {
  std::vector<double> distances;  ///< robust, shape (poses)
  double expected = 0.0;          ///< of their sum, were the model right
};

/// P(chi^2 > x) with n degrees of freedom, by the recursion Q_n = Q_(n-2) + (x/2)^(n/2 - 1) e^(-x/2) / Gamma(n/2).
double chiSquaredTail(double x, int n) {
  if (x <= 0.0) return 1.0;
  const double half = 0.5 * x;
  if (n == 1) return std::erfc(std::sqrt(half));
  if (n == 2) return std::exp(-half);
  return chiSquaredTail(x, n - 2) + std::exp((0.5 * n - 1.0) * std::log(half) - half - std::lgamma(0.5 * n));
}

int fittedParameters(const ArmEffect& effect) {
  return static_cast<int>(std::ranges::count_if(effect.parameters, [](const auto& p) { return p.fitted; }));
}

class Selection {
 public:
  Selection(const PoseProblem& problem, std::span<const Pose> poses, const std::vector<PoseHypothesis>& hypotheses,
            const PoseDiagnosisOptions& options)
      : problem_(problem), poses_(poses), hypotheses_(hypotheses), options_(options), folds_(interleavedFolds(poses)) {}

  PoseSelection run(const Eigen::VectorXd& start, const std::function<void(std::string_view)>& stage);

 private:
  PoseFit refit(const std::vector<PoseCause>& causes, PoseFit& like, const Eigen::VectorXd& z,
                double tolerance = 1e-7) const;
  PoseFit settled(const std::vector<PoseCause>& causes, const Eigen::VectorXd& z) const;
  std::vector<PoseHypothesis> openBeside(const std::vector<PoseCause>& causes) const;
  std::vector<PoseCandidate> tryAll(PoseFit& fit, const std::vector<PoseHypothesis>& hypotheses) const;
  CrossValidation crossValidate(const std::vector<PoseCause>& causes, const Eigen::VectorXd& z,
                                const std::vector<PoseCause>& like, const Eigen::VectorXd& z_like) const;
  bool improveBase(PoseFit& fit, const PoseCandidate& candidate) const;
  double price(const std::vector<PoseHypothesis>& hypotheses) const;
  double pAdjusted(const PoseCandidate& candidate, double tries) const;
  bool step(PoseFit& fit, PoseSelection& selection);
  void exchange(PoseFit& fit, PoseSelection& selection);
  void prune(PoseFit& fit, PoseSelection& selection);

  const PoseProblem& problem_;
  std::span<const Pose> poses_;
  std::vector<PoseHypothesis> hypotheses_;
  const PoseDiagnosisOptions& options_;
  std::vector<Fold> folds_;
};

PoseFit Selection::refit(const std::vector<PoseCause>& causes, PoseFit& like, const Eigen::VectorXd& z,
                         double tolerance) const {
  PoseFit fit(problem_, poses_, causes);
  fit.posterior().whitenLike(like.posterior());
  fit.descend(fit.extended(z), tolerance);
  return fit;
}

/// Whitened anew with its own solution.
PoseFit Selection::settled(const std::vector<PoseCause>& causes, const Eigen::VectorXd& z) const {
  PoseFit fit(problem_, poses_, causes);
  fit.posterior().whiten(z);
  fit.descend(z);
  return fit;
}

std::vector<PoseHypothesis> Selection::openBeside(const std::vector<PoseCause>& causes) const {
  std::vector<PoseHypothesis> open;
  for (const PoseHypothesis& h : hypotheses_) {
    const auto same = [&](const PoseCause& cause) { return cause.effect == h.effect && cause.target == h.target; };
    if (std::ranges::none_of(causes, same)) open.push_back(h);
  }
  return open;
}

/// Every hypothesis beside the causes of `fit`, each with all its starts; the best start of each.
std::vector<PoseCandidate> Selection::tryAll(PoseFit& fit, const std::vector<PoseHypothesis>& hypotheses) const {
  struct Try {
    std::size_t hypothesis;
    PoseCause cause;
    PoseCandidate result;
  };
  std::vector<Try> tries;
  for (std::size_t h = 0; h < hypotheses.size(); ++h) {
    for (const EffectParameters& start : hypotheses[h].starts) {
      tries.push_back({h, {hypotheses[h].effect, hypotheses[h].target, start}, {}});
    }
  }
  const double evidence = fit.logEvidence();
  forEach(problem_, tries.size(), [&](std::size_t t) {
    std::vector<PoseCause> causes = fit.causes();
    causes.push_back(tries[t].cause);
    PoseFit more = refit(causes, fit, fit.z(), kTryTolerance);
    tries[t].result = {tries[t].cause, more.z(), more.logEvidence() - evidence, fit.objective() - more.objective()};
  });
  std::vector<PoseCandidate> best(hypotheses.size());
  for (PoseCandidate& candidate : best) candidate.evidence = -std::numeric_limits<double>::infinity();
  for (const Try& one : tries) {
    if (one.result.evidence > best[one.hypothesis].evidence) best[one.hypothesis] = one.result;
  }
  std::erase_if(best, [](const PoseCandidate& candidate) { return std::isinf(candidate.evidence); });
  std::ranges::stable_sort(best, std::greater<>(), &PoseCandidate::evidence);
  return best;
}

CrossValidation Selection::crossValidate(const std::vector<PoseCause>& causes, const Eigen::VectorXd& z,
                                         const std::vector<PoseCause>& like, const Eigen::VectorXd& z_like) const {
  CrossValidation result;
  result.distances.resize(poses_.size());
  std::vector<double> expected(kFolds);
  forEach(problem_, kFolds, [&](std::size_t f) {
    const Fold& fold = folds_[f];
    PoseFit whitening(problem_, fold.training, like);
    whitening.posterior().whiten(z_like);
    whitening.setSolution(z_like);
    PoseFit fit(problem_, fold.training, causes);
    fit.posterior().whitenLike(whitening.posterior());
    fit.descend(z);
    const std::vector<double> unseen = unseenDistances(fit, problem_, fold.validation, whitening);
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      result.distances[fold.validation_index[i]] = robustLoss(unseen[i]);
    }
    const Eigen::LLT<Eigen::MatrixXd> curvature(fit.curvature());
    PoseFit there(problem_, fold.validation, causes);
    there.posterior().whiten(fit.z());
    for (const PoseResidual& pose : there.posterior().evaluate(fit.z(), true)) {
      const Eigen::MatrixXd left = curvature.matrixL().solve(pose.jacobian.transpose());
      expected[f] += static_cast<double>(pose.error.size()) + left.squaredNorm();
    }
  });
  result.expected = std::accumulate(expected.begin(), expected.end(), 0.0);
  return result;
}

/// Log of how many hypotheses a step tries.
double Selection::price(const std::vector<PoseHypothesis>& hypotheses) const {
  double tries = 0.0;
  for (const PoseHypothesis& h : hypotheses) {
    const bool slip = h.effect->name == "potentiometer-slip";
    tries += slip ? 0.25 * static_cast<double>(poses_.size()) : 1.0;  // neighbouring moments are no new hypotheses
  }
  return std::log(std::max(1.0, tries));
}

double Selection::pAdjusted(const PoseCandidate& candidate, double tries) const {
  return std::min(1.0, tries * chiSquaredTail(2.0 * candidate.likelihood, fittedParameters(*candidate.cause.effect)));
}

/// A hypothesis may have found the way out of a local minimum that had nothing to do with it: then the model without it
/// goes there too. \returns whether that was better
bool Selection::improveBase(PoseFit& fit, const PoseCandidate& candidate) const {
  PoseFit other = refit(fit.causes(), fit, candidate.z.head(fit.z().size()));
  if (!(other.objective() < fit.objective() - kSameMinimum)) return false;
  fit = std::move(other);
  return true;
}

/// One forward step. \returns whether a cause was accepted
bool Selection::step(PoseFit& fit, PoseSelection& selection) {
  std::vector<PoseHypothesis> open = openBeside(fit.causes());
  placeSlips(problem_, fit, open);
  std::vector<PoseCandidate> candidates = tryAll(fit, open);
  for (int round = 0; round < kBetterBases && !candidates.empty() && improveBase(fit, candidates.front()); ++round) {
    candidates = tryAll(fit, open);
  }
  if (fit.causes().empty()) selection.z_plain = fit.z();
  const double paid = price(open);
  const std::size_t number = selection.causes.size() + 1;
  const CrossValidation before = crossValidate(fit.causes(), fit.z(), fit.causes(), fit.z());
  const PoseCandidate* accepted = nullptr;
  std::size_t tried = 0;
  for (const PoseCandidate& candidate : candidates) {
    HypothesisRecord record{number, std::string(candidate.cause.effect->name), candidate.cause.target, {}, 1.0, ""};
    record.p_adjusted = pAdjusted(candidate, std::exp(paid));
    const double odds = candidate.evidence - paid;
    if (odds < kClearOdds || record.p_adjusted > options_.level) {
      record.outcome = fmt::format("rejected: log odds {:.1f}", odds);
    } else if (!accepted && tried < kTried) {
      ++tried;
      std::vector<PoseCause> causes = fit.causes();
      causes.push_back(candidate.cause);
      const CrossValidation after = crossValidate(causes, candidate.z, fit.causes(), fit.z());
      record.gain_inner = pairedGain(before.distances, after.distances, options_.seed);
      // Few poses let a wrong cause look good by absorbing what the priors do not: then it has to be clear of chance.
      const double gain = poses_.size() < kFewPoses ? record.gain_inner.lower95 : record.gain_inner.value;
      if (gain < kSmallestGain) {
        record.outcome = "rejected: no gain on inner validation poses";
      } else {
        record.outcome = "accepted";
        accepted = &candidate;
        AcceptedCause cause{candidate.cause, odds, record.p_adjusted, record.gain_inner, {}, {}};
        for (const PoseCandidate& other : candidates) {
          if (other.evidence > candidate.evidence - kHopeless) cause.contenders.insert(other.cause.label());
        }
        selection.causes.push_back(std::move(cause));
      }
    } else {
      record.outcome = "passed over";
    }
    selection.records.push_back(std::move(record));
  }
  if (!accepted) return false;
  std::vector<PoseCause> causes = fit.causes();
  causes.push_back(accepted->cause);
  fit = settled(causes, accepted->z);
  return true;
}

/// Each cause against all rivals in its place, with the other causes there: the best stays, those near it are listed.
/// A cause that was tried goes to the end of the line, so that all stand in their order again when each has been.
void Selection::exchange(PoseFit& fit, PoseSelection& selection) {
  for (std::size_t turn = selection.causes.size(); turn > 0; --turn) {
    AcceptedCause cause = selection.causes.front();
    selection.causes.erase(selection.causes.begin());
    std::vector<PoseCause> causes = fit.causes();
    causes.erase(causes.begin());
    PoseFit without = refit(causes, fit, fit.solutionWithout(0));
    std::vector<PoseHypothesis> open = openBeside(causes);
    const double paid = price(open);
    std::erase_if(open, [&](const PoseHypothesis& h) {
      return !cause.contenders.contains(PoseCause{h.effect, h.target, {}}.label());
    });
    placeSlips(problem_, without, open);
    const std::vector<PoseCandidate> candidates = tryAll(without, open);
    if (candidates.empty()) {
      selection.causes.push_back(cause);
      causes.push_back(cause.cause);
      fit = refit(causes, fit, without.z());
      continue;
    }
    const PoseCandidate& best = candidates.front();
    if (best.cause.label() != cause.cause.label()) {
      selection.records.push_back({selection.causes.size() + 2,
                                   std::string(cause.cause.effect->name),
                                   cause.cause.target,
                                   {},
                                   1.0,
                                   "exchanged for " + best.cause.label()});
    }
    cause.cause = best.cause;
    cause.odds = best.evidence - paid;
    cause.p_adjusted = pAdjusted(best, std::exp(paid));
    cause.rivals.clear();
    for (std::size_t r = 1; r < candidates.size(); ++r) {
      if (best.evidence - candidates[r].evidence < kTellApart) cause.rivals.push_back(candidates[r].cause.label());
    }
    selection.causes.push_back(cause);
    causes.push_back(best.cause);
    fit = settled(causes, best.z);
  }
}

/// Removes causes that the later ones have made needless.
void Selection::prune(PoseFit& fit, PoseSelection& selection) {
  for (std::size_t c = selection.causes.size(); c-- > 0 && selection.causes.size() > 1;) {
    if (selection.causes[c].odds >= kClearOdds) continue;
    selection.records.push_back({selection.causes.size() + 1,
                                 std::string(selection.causes[c].cause.effect->name),
                                 selection.causes[c].cause.target,
                                 {},
                                 1.0,
                                 "pruned"});
    std::vector<PoseCause> causes = fit.causes();
    causes.erase(causes.begin() + static_cast<std::ptrdiff_t>(c));
    selection.causes.erase(selection.causes.begin() + static_cast<std::ptrdiff_t>(c));
    fit = settled(causes, fit.solutionWithout(c));
  }
}

PoseSelection Selection::run(const Eigen::VectorXd& start, const std::function<void(std::string_view)>& stage) {
  PoseSelection selection;
  PoseFit fit = settled({}, start);
  do {
    stage(fmt::format("step {}", selection.causes.size() + 1));
  } while (step(fit, selection) && selection.causes.size() < options_.max_causes);
  stage("rivals");
  exchange(fit, selection);
  prune(fit, selection);
  selection.z = fit.z();
  const CrossValidation last = crossValidate(fit.causes(), fit.z(), fit.causes(), fit.z());
  const auto excess = [](const CrossValidation& result) {
    return std::accumulate(result.distances.begin(), result.distances.end(), 0.0) / result.expected - 1.0;
  };
  selection.excess = excess(last);
  selection.excess_plain = excess(crossValidate({}, selection.z_plain, {}, selection.z_plain));
  selection.excess_sd = std::sqrt(2.0 / last.expected);
  return selection;
}

}  // namespace

PoseSelection selectCauses(const PoseProblem& problem, std::span<const Pose> poses,
                           const std::vector<PoseHypothesis>& hypotheses, const Eigen::VectorXd& start,
                           const PoseDiagnosisOptions& options, const std::function<void(std::string_view)>& stage) {
  return Selection(problem, poses, hypotheses, options).run(start, stage);
}

Interval pairedGain(std::span<const double> before, std::span<const double> after, std::uint64_t seed) {
  constexpr std::uint32_t kDraws = 2000;
  const auto n = before.size();
  const CounterRandom random(seed);
  std::vector<double> gains(kDraws);
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    double sum_before = 0.0, sum_after = 0.0;
    for (std::uint32_t i = 0; i < n; ++i) {
      const auto p = static_cast<std::size_t>(random.uniform({draw, i, 0, kBootstrapPurpose}) * static_cast<double>(n));
      sum_before += before[p];
      sum_after += after[p];
    }
    gains[draw] = sum_before > 0.0 ? 1.0 - sum_after / sum_before : 0.0;
  }
  std::ranges::sort(gains);
  const double sum_before = std::accumulate(before.begin(), before.end(), 0.0);
  const double sum_after = std::accumulate(after.begin(), after.end(), 0.0);
  return {sum_before > 0.0 ? 1.0 - sum_after / sum_before : 0.0, gains[kDraws / 40], gains[kDraws - 1 - kDraws / 40]};
}

std::vector<PoseHypothesis> poseHypotheses(const ArmModel& model, std::span<const Pose> poses,
                                           const std::vector<std::string>& effects,
                                           std::vector<NotTestable>& not_testable) {
  const bool timed = std::ranges::none_of(poses, [](const Pose& pose) { return std::isnan(pose.time); });
  std::vector<PoseHypothesis> hypotheses;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (!effects.empty() && std::ranges::find(effects, effect->name) == effects.end()) continue;
    if (effect->needs_time && !timed) {
      not_testable.push_back({std::string(effect->name), "needs time_s"});
      continue;
    }
    for (const std::string& target : effectTargets(*effect, model)) {
      PoseHypothesis hypothesis{effect, target, {}};
      for (const EffectParameters& start : effect->starts) {
        Extension extension = makeExtension(*effect, target, start);
        if (!checkExtension(extension, model).empty()) continue;
        if (effect->stiction && effect->stiction(start).from_previous && !timed) continue;
        hypothesis.starts.push_back(start);
      }
      const Extension named{std::string(effect->name), target, {}};
      const auto given = [&](const Extension& other) { return extensionLabel(other) == extensionLabel(named); };
      if (hypothesis.starts.empty() || std::ranges::any_of(model.extensions, given)) continue;
      hypotheses.push_back(std::move(hypothesis));
    }
  }
  return hypotheses;
}

}  // namespace simgap
