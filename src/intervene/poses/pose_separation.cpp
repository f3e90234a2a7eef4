#include "simgap/intervene/poses/pose_separation.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "intervene/held_causes.h"
#include "pose_weighing.h"
#include "simgap/core/error.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/poses/pose_uncertainty.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What every model says of every command.
struct Foreseen {
  std::vector<Predicted> predictions;  ///< shape (candidates)
  std::vector<SeparatedPair> pairs;
  Index dof = 0;
  double scale = 1.0;  ///< of S: what the diagnosis left unexplained

  MatrixXd jacobian(std::size_t model, std::size_t command) const {
    return predictions[model].spread.middleRows(dof * static_cast<Index>(command), dof);
  }
  VectorXd apart(const SeparatedPair& pair, std::size_t command) const {
    return predictions[pair.wrong].whitening[command] *
           (predictions[pair.right].raw[command] - predictions[pair.wrong].raw[command]);
  }
};

/// Poses recorded one after the other, as every pair of models expects them.
class Sequence {
 public:
  explicit Sequence(const Foreseen& foreseen) : foreseen_(foreseen), log_odds_(foreseen.pairs.size(), 0.0) {
    for (const Predicted& prediction : foreseen.predictions) {
      left_.push_back(MatrixXd::Identity(prediction.spread.cols(), prediction.spread.cols()));
    }
    for (const SeparatedPair& pair : foreseen.pairs) turned_.push_back(VectorXd::Zero(left_[pair.wrong].rows()));
  }

  double smallest() const { return *std::ranges::min_element(log_odds_); }

  /// Sum of exp(-log odds) over all pairs, were the command recorded next.
  double doubtAfter(std::size_t command) const {
    std::vector<std::optional<Eigen::LLT<MatrixXd>>> factors(left_.size());
    double doubt = 0.0;
    for (std::size_t k = 0; k < foreseen_.pairs.size(); ++k) {
      const SeparatedPair& pair = foreseen_.pairs[k];
      const MatrixXd jacobian = foreseen_.jacobian(pair.wrong, command);
      if (!factors[pair.wrong]) factors[pair.wrong] = innovation(pair.wrong, jacobian);
      const VectorXd v = foreseen_.apart(pair, command) - jacobian * turned_[k];
      doubt += std::exp(-log_odds_[k] - gain(v, *factors[pair.wrong]));
    }
    return doubt;
  }

  void add(std::size_t command) {
    for (std::size_t k = 0; k < foreseen_.pairs.size(); ++k) {
      const SeparatedPair& pair = foreseen_.pairs[k];
      const MatrixXd jacobian = foreseen_.jacobian(pair.wrong, command);
      const Eigen::LLT<MatrixXd> factor = innovation(pair.wrong, jacobian);
      const VectorXd v = foreseen_.apart(pair, command) - jacobian * turned_[k];
      log_odds_[k] += gain(v, factor);
      turned_[k] += left_[pair.wrong] * jacobian.transpose() * factor.solve(v);
    }
    for (std::size_t c = 0; c < left_.size(); ++c) {
      const MatrixXd jacobian = foreseen_.jacobian(c, command);
      const MatrixXd cross = left_[c] * jacobian.transpose();
      left_[c] -= cross * innovation(c, jacobian).solve(cross.transpose());
    }
  }

 private:
  Eigen::LLT<MatrixXd> innovation(std::size_t model, const MatrixXd& jacobian) const {
    MatrixXd s = jacobian * left_[model] * jacobian.transpose();
    s.diagonal().array() += 1.0;
    return s.llt();
  }
  double gain(const VectorXd& v, const Eigen::LLT<MatrixXd>& factor) const {
    return 0.5 * v.dot(factor.solve(v)) / foreseen_.scale;
  }

  const Foreseen& foreseen_;
  std::vector<MatrixXd> left_;    ///< shape (candidates): C
  std::vector<VectorXd> turned_;  ///< shape (pairs): x
  std::vector<double> log_odds_;  ///< shape (pairs)
};

/// The named model against each that contradicts it, either of them right.
std::vector<SeparatedPair> pairsOf(const PoseEvidence& evidence) {
  const std::vector<bool> rival = rivalsOf(heldBy(evidence));
  std::vector<SeparatedPair> pairs;
  for (std::size_t c = 1; c < rival.size(); ++c) {
    if (rival[c]) pairs.insert(pairs.end(), {{0, c, 0.0}, {c, 0, 0.0}});
  }
  if (pairs.empty()) {
    throw ConfigError(fmt::format("found no model that contradicts {}: there is nothing to tell apart",
                                  evidence.candidates.front().causes));
  }
  return pairs;
}

/// When a pose recorded after the others will be: some causes creep or slip.
double timeAfter(const std::vector<Pose>& poses) {
  std::vector<double> times;
  for (const Pose& pose : poses) {
    if (std::isfinite(pose.time)) times.push_back(pose.time);
  }
  if (times.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::sort(times);
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return times.back() + median(steps);
}

std::vector<Pose> commandsOf(const PoseEvidence& evidence, const SeparationOptions& options) {
  const PosePrediction named(evidence, evidence.candidates.front());
  std::vector<Pose> commands =
      named.atPosterior(evidence.poses, [&](const PosePosterior& posterior, const VectorXd& z) {
        return drawCommands(posterior, z, options.candidates, options.seed, options.most_tension);
      });
  const double time = timeAfter(evidence.poses);
  for (Pose& command : commands) command.time = time;
  return commands;
}

Foreseen foreseenOf(const PoseEvidence& evidence, const std::vector<Pose>& commands) {
  Foreseen foreseen{std::vector<Predicted>(evidence.candidates.size()), pairsOf(evidence), 0,
                    1.0 + std::max(0.0, evidence.excess)};
  forEach(problemOf(evidence, evidence.candidates.front()), evidence.candidates.size(), [&](std::size_t c) {
    foreseen.predictions[c] = PosePrediction(evidence, evidence.candidates[c]).after({}, commands);
  });
  foreseen.dof = foreseen.predictions.front().dof;
  return foreseen;
}

/// Random commands in their order.
std::vector<std::size_t> randomOrder(std::vector<std::size_t> left, std::size_t count, const CounterRandom& random,
                                     std::uint32_t draw) {
  constexpr std::uint32_t kPurpose = 71;
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < count; ++k) {
    const double u =
        random.uniform({.generation = draw, .individual = static_cast<std::uint32_t>(k), .purpose = kPurpose});
    const auto at = left.begin() + static_cast<std::ptrdiff_t>(u * static_cast<double>(left.size()));
    order.push_back(*at);
    left.erase(at);
  }
  return order;
}

/// The mean over draws of what as many random commands tell, after 1, 2 … of them.
std::vector<double> randomlyChosen(const Foreseen& foreseen, const std::vector<std::size_t>& usable, std::size_t count,
                                   std::uint64_t seed) {
  constexpr std::uint32_t kDraws = 20;
  std::vector<double> mean(count, 0.0);
  const CounterRandom random(seed);
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    Sequence sequence(foreseen);
    const std::vector<std::size_t> order = randomOrder(usable, count, random, draw);
    for (std::size_t k = 0; k < count; ++k) {
      sequence.add(order[k]);
      mean[k] += sequence.smallest() / kDraws;
    }
  }
  return mean;
}

/// Recorded and judged, were each pair's right model right: the median of the draws.
std::vector<SeparatedPair> played(const PoseEvidence& evidence, const std::vector<Pose>& poses, std::uint64_t seed) {
  constexpr std::size_t kDraws = 9;
  std::vector<SeparatedPair> pairs = pairsOf(evidence);
  std::set<std::size_t> rights;
  for (const SeparatedPair& pair : pairs) rights.insert(pair.right);
  std::vector<std::vector<double>> odds(pairs.size());  // of the draws that the right model could be recorded at
  for (const std::size_t right : rights) {
    const PosePrediction prediction(evidence, evidence.candidates[right]);
    std::vector<std::vector<double>> said(kDraws);
    forEach(problemOf(evidence, evidence.candidates[right]), kDraws, [&](std::size_t draw) {
      const auto after = prediction.recorded(poses, seed, static_cast<std::uint32_t>(draw));
      if (!after) return;
      const auto weigh = [&](std::size_t c) {
        return weighAfter(evidence, evidence.candidates[c], {}, *after).log_likelihood;
      };
      const double of_right = weigh(right);
      for (const SeparatedPair& pair : pairs) {
        if (pair.right == right) said[draw].push_back(of_right - weigh(pair.wrong));
      }
    });
    for (const std::vector<double>& of_draw : said) {
      std::size_t place = 0;
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        if (pairs[k].right == right && !of_draw.empty()) odds[k].push_back(of_draw[place++]);
      }
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (odds[k].empty()) {
      throw NumericsError(fmt::format("no arm like {} has an equilibrium at all of the poses to record",
                                      evidence.candidates[pairs[k].right].causes));
    }
    pairs[k].log_odds = median(odds[k]);
  }
  return pairs;
}

double smallestOf(const std::vector<SeparatedPair>& pairs) {
  return std::ranges::min_element(pairs, {}, &SeparatedPair::log_odds)->log_odds;
}

}  // namespace

PoseSeparation separatePoses(const PoseEvidence& evidence, const SeparationOptions& options) {
  static_cast<void>(pairsOf(evidence));  // before any work
  const std::vector<Pose> commands = commandsOf(evidence, options);
  const Foreseen foreseen = foreseenOf(evidence, commands);
  std::vector<std::size_t> usable;
  for (std::size_t q = 0; q < commands.size(); ++q) {
    if (std::ranges::all_of(foreseen.predictions, [&](const Predicted& p) { return bool(p.valid[q]); }))
      usable.push_back(q);
  }
  if (usable.size() < options.poses) {
    throw NumericsError(
        fmt::format("only {} of {} commands lead to an equilibrium of every model{}, expected {} at least",
                    usable.size(), options.candidates,
                    std::isfinite(options.most_tension)
                        ? fmt::format(" with no muscle pulled by more than {:g} N", options.most_tension)
                        : "",
                    options.poses));
  }
  PoseSeparation result;
  result.smallest_random = randomlyChosen(foreseen, usable, options.poses, options.seed);
  std::vector<Pose> random;
  for (const std::size_t q : randomOrder(usable, options.poses, CounterRandom(options.seed), 0)) {
    random.push_back(commands[q]);
  }
  Sequence sequence(foreseen);
  for (std::size_t k = 0; k < options.poses; ++k) {
    std::vector<double> doubt(usable.size());
    forEach(problemOf(evidence, evidence.candidates.front()), usable.size(),
            [&](std::size_t i) { doubt[i] = sequence.doubtAfter(usable[i]); });
    const auto best = std::ranges::min_element(doubt) - doubt.begin();
    const std::size_t command = usable[best];
    usable.erase(usable.begin() + best);
    sequence.add(command);
    result.poses.push_back(commands[command]);
    result.poses.back().name = fmt::format("next-{}", k + 1);
    result.smallest.push_back(sequence.smallest());
  }
  result.pairs = played(evidence, result.poses, options.seed);
  result.promised = smallestOf(result.pairs);
  result.promised_random = smallestOf(played(evidence, random, options.seed));
  return result;
}

}  // namespace simgap
