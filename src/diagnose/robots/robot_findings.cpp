#include "robot_findings.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "diagnose/surrogates.h"
#include "diagnose/verdict.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Why a delay of a joint may be none: bristles of which no log says how far they bend are late, too.
std::string bristlesInstead(const RobotSearch& search, const RobotHypothesis& hypothesis) {
  if (!hypothesis.isDelay()) return {};
  const std::vector<RobotJointLog>& joints = search.rows().log().joints;
  const auto joint = std::ranges::find(joints, hypothesis.target, &RobotJointLog::name);
  if (joint == joints.end() || joint->presliding == 0.0 || joint->presliding > kUntold) return {};
  return "no log tells over what travel this joint's friction builds up, which is late as well";
}

/// Rows of training blocks that count for a joint.
std::vector<Index> trainingRows(const RobotSearch& search, std::size_t joint) {
  std::vector<Index> counted;
  const RobotLog& log = search.rows().log();
  for (std::size_t b = 0; b < log.blocks.size(); ++b) {
    if (!search.ground().training[b]) continue;
    for (std::size_t row = log.blocks[b].begin; row < log.blocks[b].end; ++row) {
      if (search.rows().counts(row, joint)) counted.push_back(static_cast<Index>(row));
    }
  }
  return counted;
}

ExtraColumn placeboOf(const RobotSearch& search, const ExtraColumn& signature, std::uint32_t draw, std::uint64_t seed) {
  ExtraColumn placebo(signature.size());
  for (std::size_t c = 0; c < signature.size(); ++c) {
    if (signature[c].size() == 0) continue;
    const std::vector<Index> rows = trainingRows(search, c);
    if (rows.size() < 20) continue;
    const VectorXd drawn =
        phaseRandomised(signature[c](rows).matrix(), draw * 64 + static_cast<std::uint32_t>(c), seed);
    placebo[c] = ArrayXd::Zero(signature[c].size());
    placebo[c](rows) = drawn.array();
  }
  return placebo;
}

bool hasNoColour(const RobotSearch& search, const ExtraColumn& signature) {
  for (std::size_t c = 0; c < signature.size(); ++c) {
    if (signature[c].size() == 0) continue;
    const ArrayXd own = signature[c](trainingRows(search, c));
    if (own.size() > 0 && (own - own.mean()).square().sum() > 1e-6 * own.square().sum()) return false;
  }
  return true;
}

/// Squares that each of the last `count` columns explains beyond the base parameters. \param other  places of columns
/// whose factor is 1
VectorXd explainedAlone(const RobotNormal& normal, const RobotGround& ground, Index base, Index other, Index count) {
  VectorXd known = VectorXd::Zero(normal.b.size());
  known.head(base) = ground.x0;
  known.segment(base, other).setOnes();
  const VectorXd score = normal.b - normal.a * known;
  const Eigen::LDLT<MatrixXd> factor(MatrixXd(normal.a.topLeftCorner(base, base) + ground.precision));
  const MatrixXd cross = normal.a.block(0, base + other, base, count);
  const MatrixXd solved = factor.solve(cross);
  const VectorXd g = score.tail(count) - solved.transpose() * score.head(base);
  VectorXd gains(count);
  for (Index k = 0; k < count; ++k) {
    const Index at = base + other + k;
    const double square = normal.a(at, at) - cross.col(k).dot(solved.col(k));
    gains[k] = square > 0.0 ? g[k] * g[k] / square : 0.0;
  }
  return gains;
}

/// Why its own numbers are no measurement; empty when they are.
std::string unmeasured(const RobotSearch& search, const RobotSearch::Set& set, std::size_t cause) {
  const RobotSearch::Fit fit = search.fit(set, kRobotFolds);
  const MatrixXd covariance = search.covariance(set, fit);
  Index first = 0;
  for (std::size_t k = 0; k < cause; ++k) first += fit.theta[k].size();
  const VectorXd& theta = fit.theta[cause];
  const RobotHypothesis& hypothesis = search.hypothesis(set[cause]);
  bool any = false;
  for (Index k = 0; k < theta.size(); ++k) {
    const RobotCauseParameter& parameter = hypothesis.parameters[k];
    const double sd = std::sqrt(std::max(0.0, covariance(first + k, first + k)));
    const bool possible = theta[k] >= parameter.lower && theta[k] <= parameter.upper;
    any = any || (possible && sd > 0.0 && kNormalQuantile * sd < kMeaningless * std::abs(theta[k]));
    if (theta[k] >= parameter.lower - 2.0 * sd && theta[k] <= parameter.upper + 2.0 * sd) continue;
    return fmt::format("{} = {:.3g} is no physical size", parameter.name, theta[k] + parameter.neutral);
  }
  if (!any) return "none of its own parameters is determined by these data";
  if (hypothesis.counts && !hypothesis.counts(theta)) return "its size means nothing here";
  return {};
}

class RobotJudge {
 public:
  RobotJudge(RobotSearch& search, RobotSelector& selector, const RobotDiagnosisOptions& options,
             RobotSelection& selection)
      : search_(search),
        selector_(selector),
        options_(options),
        selection_(selection),
        heldout_(search.ground().heldout()) {}

  RobotFindings run() {
    while (takeOutPair() || takeOut()) {
    }
    for (std::size_t k = 0; k < selection_.set.size(); ++k) found_.gain.push_back(gainOf(k).gain);
    return std::move(found_);
  }

 private:
  struct Measured {
    Interval gain;
    double p;
  };

  /// By what held-out blocks lose without it, all others refitted.
  Measured gainOf(std::size_t cause) const {
    const std::vector<std::size_t>& joints = search_.joints(selection_.set[cause]);
    const auto errorsOf = [&](const RobotSearch::Set& set) {
      return groupErrors(search_.errors(search_.fit(set, kRobotFolds).z, heldout_), search_.counted(), heldout_,
                         joints);
    };
    const GroupErrors before = errorsOf(bareOf(search_, selection_.set, cause)), after = errorsOf(selection_.set);
    return {predictedGain(before.sum, after.sum, options_.seed), pairedP(before, after)};
  }

  /// \param unseen  what the set leaves, once any of its causes has come that far
  std::string reason(std::size_t cause, std::optional<RobotUnseen>& unseen) const {
    const RobotSearch::Set& set = selection_.set;
    if (std::string why = unmeasured(search_, set, cause); !why.empty()) return why;
    if (std::string why = bristlesInstead(search_, search_.hypothesis(set[cause])); !why.empty()) return why;
    const auto [gain, p] = gainOf(cause);
    constexpr double kLarge = 0.25, kLargeLevel = 0.25, kLevel = 0.05;
    if (gain.value < options_.least_gain) {
      return fmt::format("it saves {:.1f} % on held-out blocks, less than {:.1f} %", 100.0 * gain.value,
                         100.0 * options_.least_gain);
    }
    if (p > (gain.value < kLarge ? kLevel : kLargeLevel)) {
      return fmt::format("its gain of {:.1f} % on held-out blocks is not significant (p {:.2g})", 100.0 * gain.value,
                         p);
    }
    constexpr double kBeside = 0.5;  // of what it explains: with more left beside it, it may have the wrong shape
    if (!unseen) unseen.emplace(unseenOf(search_, set));
    const std::vector<std::size_t>& joints = search_.joints(set[cause]);
    if (const double left = whatIsLeft(*unseen, joints).share; left > kBeside * gain.value) {
      return fmt::format("{:.0f} % of the error are left without a name beside its {:.0f} %: it may only stand in",
                         100.0 * left, 100.0 * gain.value);
    }
    const bool of_bodies = joints.size() > 1 && !search_.hypothesis(set[cause]).isDelay();
    if (std::string why = leftBeyondKnown(*unseen, joints, of_bodies); !why.empty()) return why;
    if (const double placebo = placeboP(search_, set, cause, options_.seed); placebo > kPlaceboLevel) {
      return fmt::format("signals of the same spectrum that belong to no motion explain as much (p {:.2g})", placebo);
    }
    return {};
  }

  /// One that came back says once, and last, why it went.
  void refuse(std::size_t cause, std::string why) {
    const RobotHypothesis& h = search_.hypothesis(selection_.set[cause]);
    std::erase_if(found_.candidates, [&](const Candidate& c) { return c.effect == h.cause && c.target == h.target; });
    found_.candidates.push_back({h.cause, h.target, std::move(why), gainOf(cause).gain});
    selector_.drop(cause, selection_);
  }
  void refusePair(std::size_t cause) { refuse(cause, "with another delay of this joint: two may stand for a third"); }

  /// Two delays of one joint, which may stand for a third: a late position is an early effort of a late joint.
  bool takeOutPair() {
    const auto hypothesis = [&](std::size_t k) -> const RobotHypothesis& {
      return search_.hypothesis(selection_.set[k]);
    };
    for (std::size_t k = selection_.set.size(); k-- > 0;) {
      for (std::size_t j = k; j-- > 0;) {
        if (!hypothesis(k).isDelay() || !hypothesis(j).isDelay() || hypothesis(k).target != hypothesis(j).target)
          continue;
        const std::size_t first = selection_.set[j];
        refusePair(k);
        if (j < selection_.set.size() && selection_.set[j] == first) refusePair(j);  // no other took its place
        selector_.grow(selection_, {});
        return true;
      }
    }
    return false;
  }

  /// The weakest first: what stays may only have been best beside what went.
  bool takeOut() {
    std::optional<RobotUnseen> unseen;
    for (std::size_t k = selection_.set.size(); k-- > 0;) {
      std::string why = reason(k, unseen);
      if (why.empty()) continue;
      const bool measured = unmeasured(search_, selection_.set, k).empty();
      refuse(k, std::move(why));
      // It may have been in another's place. Of what held-out blocks refused nothing is chosen anew: they only measure.
      if (!measured) selector_.grow(selection_, {});
      return true;
    }
    return false;
  }

  RobotSearch& search_;
  RobotSelector& selector_;
  const RobotDiagnosisOptions& options_;
  RobotSelection& selection_;
  std::vector<bool> heldout_;
  RobotFindings found_;
};

}  // namespace

ExtraColumn signatureOf(const RobotRows& rows, const RobotHypothesis& hypothesis, const VectorXd& theta) {
  if (hypothesis.torque) return hypothesis.torque(theta);
  return onAll(rows.torqueOf(hypothesis.change(theta)));
}

double placeboP(const RobotSearch& search, const RobotSearch::Set& set, std::size_t cause, std::uint64_t seed) {
  const RobotRows& rows = search.rows();
  const RobotGround& ground = search.ground();
  const RobotSearch::Fit fit = search.fit(set, kRobotFolds);
  std::vector<ExtraColumn> columns;
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (k != cause) columns.push_back(signatureOf(rows, search.hypothesis(set[k]), fit.theta[k]));
  }
  const Index other = std::ssize(columns), base = std::ssize(ground.base.columns);
  const ExtraColumn own = signatureOf(rows, search.hypothesis(set[cause]), fit.theta[cause]);
  if (hasNoColour(search, own)) return 0.0;
  columns.push_back(own);
  columns.resize(columns.size() + kPlacebos);
  tbb::parallel_for(std::uint32_t{0}, kPlacebos, [&](std::uint32_t draw) {
    if (interruptRequested()) return;
    columns[static_cast<std::size_t>(other) + 1 + draw] = placeboOf(search, own, draw, seed);
  });
  stopIfInterrupted();
  const DynamicsSums sums =
      sumDynamics(rows.log(), rows.regressor(), ground.base, rows.model().curves, ground.training, columns);
  std::vector<std::vector<std::size_t>> acts;
  std::vector<double> variance;
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    std::vector<std::size_t>& of_joint = acts.emplace_back(ground.base.acts[c]);
    for (std::size_t e = 0; e < columns.size(); ++e) {
      if (columns[e][c].size() > 0) of_joint.push_back(static_cast<std::size_t>(base) + e);
    }
    variance.push_back(ground.variance[c] * ground.inflation);
  }
  const RobotNormal normal =
      normalOf(sums.total(ground.training), acts, base + std::ssize(columns), variance, ground.constants);
  const VectorXd gains = explainedAlone(normal, ground, base, other, 1 + Index{kPlacebos});
  return placeboP(gains[0], std::span<const double>(gains.data() + 1, kPlacebos));
}

RobotFindings judgeFindings(RobotSearch& search, RobotSelector& selector, const RobotDiagnosisOptions& options,
                            RobotSelection& selection) {
  return RobotJudge(search, selector, options, selection).run();
}

}  // namespace simgap
