#include "simgap/intervene/logs/log_intervention.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "diagnose/logs/log_candidates.h"
#include "log_prediction.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFarRow = 8.0;         // [sd] of a row that no candidate comes near
constexpr double kMostOutliers = 0.01;  // of the rows: more are no outliers
constexpr double kPieceSeconds = 2.0;   // errors within are alike

std::set<std::string> causesOf(const std::string& label) {
  std::set<std::string> causes;
  for (std::size_t at = 0; at < label.size();) {
    const std::size_t end = std::min(label.find(", ", at), label.size());
    causes.insert(label.substr(at, end - at));
    at = end + 2;
  }
  causes.erase("none");
  return causes;
}

HeldCauses heldBy(const LogEvidence& evidence) {
  HeldCauses held;
  for (const LogEvidence::Candidate& candidate : evidence.candidates) held.push_back(causesOf(candidate.known.causes));
  return held;
}

/// What all candidates say of one log.
struct Answers {
  ChangedLog changed;
  std::vector<PredictedRows> predicted;  ///< shape (candidates)
  double tau = 1.0;                      ///< [rows]
};

Answers askAll(const LogEvidence& evidence, const LogChanges& change, const CsvTable* recorded) {
  const HeldCauses held = heldBy(evidence);
  for (const LogChange& part : change.changes) requireHeld(held, part.cause);
  const auto rowsOf = [&](const LogChanges& what) {
    return recorded != nullptr ? changedLog(evidence, what, *recorded, true)
                               : changedLog(evidence, what, profileOf(evidence, what), false);
  };
  Answers answers{rowsOf(change), std::vector<PredictedRows>(evidence.candidates.size()), 1.0};
  std::vector<std::pair<ChangedLog, ChangedLog>> moved;
  for (const auto& [forward, back] : withinUncertainty(change)) {
    auto& [more, less] = moved.emplace_back(rowsOf(forward), rowsOf(back));
    more.rows = less.rows = answers.changed.rows;  // a bench a little different keeps other rows: the same are compared
  }
  tbb::parallel_for(std::size_t{0}, evidence.candidates.size(), [&](std::size_t c) {
    answers.predicted[c] = predictRows(evidence.candidates[c], answers.changed, moved);
  });
  answers.tau = std::max(1.0, evidence.correlation_s / answers.changed.log.data.rows.step);
  return answers;
}

/// Places among the rows that some candidate comes near; all, where too many are far off to be outliers. What is far is
/// said by the candidate that knows best: one that explains little expects large errors everywhere, and would keep any
/// outlier for those that do not.
std::vector<Index> comparable(const LogEvidence& evidence, const Answers& answers, const ArrayXd& measured) {
  double variance = std::numeric_limits<double>::infinity();
  for (const LogEvidence::Candidate& c : evidence.candidates) variance = std::min(variance, c.known.posterior.variance);
  std::vector<Index> near;
  for (Index i = 0; i < measured.size(); ++i) {
    for (std::size_t c = 0; c < answers.predicted.size(); ++c) {
      const PredictedRows& predicted = answers.predicted[c];
      const double sd = std::sqrt(variance + predicted.spread.row(i).squaredNorm());
      if (std::abs(predicted.values[i] - measured[i]) > kFarRow * sd) continue;
      near.push_back(i);
      break;
    }
  }
  const auto left_out = static_cast<double>(measured.size() - std::ssize(near));
  if (left_out <= kMostOutliers * static_cast<double>(measured.size())) return near;
  near.resize(measured.size());
  for (Index i = 0; i < measured.size(); ++i) near[i] = i;
  return near;
}

/// The piece of two seconds that a compared row lies in: (number, session).
std::pair<Index, int> pieceOf(Index compared, const Answers& answers) {
  const ActuatorRows& rows = answers.changed.log.data.rows;
  const auto length = static_cast<Index>(std::max(8.0, std::round(kPieceSeconds / rows.step)));
  const Index row = answers.changed.rows[compared];
  return {row / length, rows.session[row]};
}

/// Squared errors on pieces of the rows that are compared.
GroupErrors piecesOf(const VectorXd& errors, const std::vector<Index>& rows, const Answers& answers) {
  std::vector<std::pair<double, double>> pieces;
  std::pair<Index, int> last{-1, -1};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::pair<Index, int> place = pieceOf(rows[k], answers);
    if (place != last) pieces.emplace_back(0.0, 0.0);
    last = place;
    pieces.back().first += errors[k] * errors[k];
    pieces.back().second += 1.0;
  }
  GroupErrors groups{ArrayXd(std::ssize(pieces)), ArrayXd(std::ssize(pieces))};
  for (Index k = 0; k < groups.sum.size(); ++k) std::tie(groups.sum[k], groups.rows[k]) = pieces[k];
  return groups;
}

/// P(F > ratio) of a ratio of two mean squares.
double fTail(double ratio, double above, double below) {
  if (!(ratio > 0.0)) return 1.0;
  if (!std::isfinite(ratio)) return 0.0;
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(above, below), ratio));
}

/// Fills what the measured rows say of a candidate. \returns ln p, up to a constant that all share
double judge(const LogPosterior& known, const PredictedRows& predicted, const ArrayXd& measured,
             const std::vector<Index>& rows, const Answers& answers, LogPrediction& result) {
  const double sd = std::sqrt(known.variance), tau = answers.tau;
  const VectorXd e = ((predicted.values(rows) - measured(rows)) / sd).matrix();
  const MatrixXd a = predicted.spread(rows, Eigen::all) / sd;
  const Distance distance = distanceOf(e, a, tau);
  const double n = static_cast<double>(rows.size()) / tau, nu = known.freedom;
  result.rms = sd * std::sqrt(e.squaredNorm() / static_cast<double>(rows.size()));
  result.rms_before = sd;
  result.distance = distance.value();
  result.freedom = n;
  const double beside = fTail(distance.beside / n, freedomOf(piecesOf(distance.left, rows, answers)), nu);
  const int k = distance.directions;
  const double along = k > 0 ? fTail(distance.along / k, k, nu) : 1.0;
  result.p = std::min(1.0, 2.0 * std::min(beside, along));
  result.log_odds_before = known.log_odds;
  result.predicted = predicted.values;
  return std::lgamma(0.5 * (nu + n)) - std::lgamma(0.5 * nu) - 0.5 * n * std::log(nu) - n * std::log(sd) -
         0.5 * distance.log_volume - 0.5 * (nu + n) * std::log1p(distance.value() / nu);
}

std::string placeOf(const ActuatorRows& rows, Index row, const ActuatorData& data) {
  std::string place = fmt::format("{:.4g} s", rows.time[row]);
  if (rows.speed.size() > 0) {
    place += fmt::format(", {:.3g} {}", rows.speed[row], data.velocity_unit == "m_s" ? "m/s" : "rad/s");
  }
  if (rows.load.size() > 0) place += fmt::format(", {:.3g} {}", rows.load[row], data.load_unit);
  return place;
}

/// What of a candidate's prediction is furthest from the named one's.
void findLargestShift(const Answers& answers, std::size_t c, double variance, ForeseenLogChange& result) {
  const ArrayXd apart = (answers.predicted[c].values - answers.predicted[0].values).abs();
  Index at = 0;
  const double largest = apart.maxCoeff(&at);
  result.largest_shift.push_back(largest);
  result.in_noise.push_back(largest / std::sqrt(variance));
  const ActuatorData& data = answers.changed.log.data;
  result.where.push_back(largest > 0.0 ? placeOf(data.rows, answers.changed.rows[at], data) : "-");
}

/// What all candidates say of some of the rows.
std::vector<CandidateAnswer> weigh(const LogEvidence& evidence, const Answers& answers, const ArrayXd& measured,
                                   const std::vector<Index>& rows, std::vector<LogPrediction>& predictions) {
  const std::vector<bool> rival = rivalsOf(heldBy(evidence));
  std::vector<CandidateAnswer> said;
  double named = 0.0;
  predictions.assign(evidence.candidates.size(), {});
  for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
    const LogCandidate& known = evidence.candidates[c].known;
    LogPrediction& prediction = predictions[c];
    const double density = judge(known.posterior, answers.predicted[c], measured, rows, answers, prediction);
    if (c == 0) named = density;
    prediction.log_odds = density - named;
    said.push_back({known.causes, prediction.p, prediction.log_odds, rival[c], prediction.log_odds_before,
                    known.role == "refused"});
  }
  return said;
}

/// The rows without one piece of two seconds, and when that begins.
struct Telling {
  std::vector<Index> others;
  double begins = 0.0;  ///< [s]
};

/// The piece that speaks most for the named candidate, or against it, beside its nearest rival. A start that jerks, or
/// a push, is far from what any model says, and farthest from what the best of them says.
Telling mostTelling(const LogEvidence& evidence, const Answers& answers, const ArrayXd& measured,
                    const std::vector<Index>& rows, const std::vector<CandidateAnswer>& said, bool for_named) {
  std::size_t rival = 1;
  for (std::size_t c = 2; c < said.size(); ++c) {
    if (said[c].rival && (!said[rival].rival || said[c].log_odds > said[rival].log_odds)) rival = c;
  }
  const auto squares = [&](std::size_t c, Index i) {
    return std::pow(answers.predicted[c].values[i] - measured[i], 2) / evidence.candidates[c].known.posterior.variance;
  };
  std::map<std::pair<Index, int>, double> told;
  for (const Index i : rows) {
    told[pieceOf(i, answers)] += (squares(rival, i) - squares(0, i)) * (for_named ? 1.0 : -1.0);
  }
  const auto most = std::ranges::max_element(told, {}, [](const auto& piece) { return piece.second; })->first;
  Telling telling;
  bool begun = false;
  for (const Index i : rows) {
    if (pieceOf(i, answers) != most) {
      telling.others.push_back(i);
    } else if (!std::exchange(begun, true)) {
      telling.begins = answers.changed.log.data.rows.time[answers.changed.rows[i]];
    }
  }
  return telling;
}

/// No verdict hangs on two seconds: it has to stand without those that speak most for it.
Judgement withoutTheMostTelling(Judgement judgement, const LogEvidence& evidence, const Answers& answers,
                                const ArrayXd& measured, const std::vector<Index>& rows,
                                const std::vector<CandidateAnswer>& said) {
  const bool confirmed = judgement.verdict == InterventionVerdict::kConfirmed;
  if (judgement.verdict == InterventionVerdict::kCannotTell || said.size() < 2) return judgement;
  const Telling telling = mostTelling(evidence, answers, measured, rows, said, confirmed);
  if (!telling.others.empty()) {
    std::vector<LogPrediction> predictions;
    const std::vector<CandidateAnswer> without = weigh(evidence, answers, measured, telling.others, predictions);
    const bool stands = confirmed ? std::ranges::none_of(without,
                                                         [](const CandidateAnswer& answer) {
                                                           return answer.rival && answer.log_odds >= -kDecisiveLogOdds;
                                                         })
                                  : judgeCandidates(without, "rows").verdict == judgement.verdict;
    if (stands) return judgement;
  }
  return {InterventionVerdict::kCannotTell,
          fmt::format("but for {:g} s from {:.4g} s on, these rows do not tell {} from the other models: record more",
                      kPieceSeconds, telling.begins, said.front().causes)};
}

}  // namespace

LogIntervention judgeChange(const LogEvidence& evidence, const LogChanges& change, const CsvTable& after) {
  const Answers answers = askAll(evidence, change, &after);
  const ActuatorRows& rows = answers.changed.log.data.rows;
  LogIntervention result;
  result.unit = answers.changed.log.data.effort_unit;
  result.time = rows.time(answers.changed.rows);
  result.measured = rows.effort(answers.changed.rows);
  const std::vector<Index> compared = comparable(evidence, answers, result.measured);
  result.rows = compared.size();
  result.left_out = static_cast<std::size_t>(result.measured.size()) - compared.size();
  const std::vector<CandidateAnswer> said = weigh(evidence, answers, result.measured, compared, result.predictions);
  Judgement judgement =
      withoutTheMostTelling(judgeCandidates(said, "rows"), evidence, answers, result.measured, compared, said);
  result.verdict = judgement.verdict;
  result.sentence = std::move(judgement.sentence);
  return result;
}

ForeseenLogChange foreseeChange(const LogEvidence& evidence, const LogChanges& change) {
  const Answers answers = askAll(evidence, change, nullptr);
  const std::size_t n = answers.predicted.size();
  ForeseenLogChange result;
  result.unit = answers.changed.log.data.effort_unit;
  result.time = answers.changed.log.data.rows.time(answers.changed.rows);
  result.log_odds.assign(n, std::vector<double>(n, 0.0));
  result.smallest = std::numeric_limits<double>::infinity();
  const std::vector<bool> rival = rivalsOf(heldBy(evidence));
  for (std::size_t j = 0; j < n; ++j) {
    const double variance = evidence.candidates[j].known.posterior.variance, sd = std::sqrt(variance);
    const MatrixXd a = answers.predicted[j].spread / sd;
    for (std::size_t i = 0; i < n; ++i) {
      if (i == j) continue;
      const VectorXd apart = ((answers.predicted[i].values - answers.predicted[j].values) / sd).matrix();
      result.log_odds[i][j] = 0.5 * distanceOf(apart, a, answers.tau).value();
      const bool asked = (i == 0 && rival[j]) || (j == 0 && rival[i]);
      if (asked) result.smallest = std::min(result.smallest, result.log_odds[i][j]);
    }
    findLargestShift(answers, j, variance, result);
    result.predicted.push_back(answers.predicted[j].values);
  }
  return result;
}

}  // namespace simgap
