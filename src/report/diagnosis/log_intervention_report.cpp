#include "simgap/report/diagnosis/log_intervention_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "intervention_tables.h"
#include "simgap/core/csv.h"

namespace simgap {
namespace {

CsvWriter predictionsOf(const LogEvidence& evidence, bool measured) {
  std::vector<std::string> header = {"time_s"};
  if (measured) header.emplace_back("measured");
  for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
    header.push_back(fmt::format("{:02} {}", c, evidence.candidates[c].known.causes));
  }
  return CsvWriter(header);
}

}  // namespace

Json toJson(const LogIntervention& result, const LogEvidence& evidence, const LogChanges& change) {
  Json candidates = Json::array();
  for (std::size_t c = 0; c < result.predictions.size(); ++c) {
    const LogPrediction& prediction = result.predictions[c];
    candidates.push_back({{"causes", evidence.candidates[c].known.causes},
                          {"role", evidence.candidates[c].known.role},
                          {"rms", numberOrNull(prediction.rms)},
                          {"rms_before", prediction.rms_before},
                          {"distance", numberOrNull(prediction.distance)},
                          {"freedom", prediction.freedom},
                          {"p", numberOrNull(prediction.p)},
                          {"log_odds_before", prediction.log_odds_before},
                          {"log_odds", numberOrNull(prediction.log_odds)}});
  }
  return {{"format", "simgap/intervene/1"},
          {"change", change.name},
          {"verdict", toString(result.verdict)},
          {"sentence", result.sentence},
          {"rows", result.rows},
          {"rows_given", result.rows + result.left_out},
          {"unit", result.unit},
          {"candidates", candidates}};
}

std::string predictionsCsv(const LogIntervention& result, const LogEvidence& evidence) {
  CsvWriter csv = predictionsOf(evidence, true);
  for (Eigen::Index i = 0; i < result.time.size(); ++i) {
    csv.add(result.time[i]).add(result.measured[i]);
    for (const LogPrediction& prediction : result.predictions) csv.add(prediction.predicted[i]);
    csv.endRow();
  }
  return csv.text();
}

std::size_t bestOf(const std::vector<ForeseenLogChange>& foreseen) {
  const auto best = std::ranges::max_element(foreseen, {}, &ForeseenLogChange::smallest);
  return static_cast<std::size_t>(best - foreseen.begin());
}

Json toJson(const std::vector<ForeseenLogChange>& foreseen, const LogEvidence& evidence,
            const std::vector<LogChanges>& changes) {
  Json list = Json::array();
  for (std::size_t k = 0; k < foreseen.size(); ++k) {
    const ForeseenLogChange& change = foreseen[k];
    Json candidates = Json::array();
    for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
      candidates.push_back({{"causes", evidence.candidates[c].known.causes},
                            {"role", evidence.candidates[c].known.role},
                            {"largest_shift", change.largest_shift[c]},
                            {"in_noise", change.in_noise[c]},
                            {"where", change.where[c]},
                            {"log_odds_if_named", change.log_odds[0][c]},
                            {"log_odds_if_this", change.log_odds[c][0]}});
    }
    list.push_back(
        {{"name", changes[k].name}, {"smallest_log_odds", numberOrNull(change.smallest)}, {"candidates", candidates}});
  }
  const std::size_t best = bestOf(foreseen);
  return {{"format", "simgap/intervene/1"},
          {"verdict", "foreseen"},
          {"sentence",
           foreseenSentence(evidence.candidates.front().known.causes, changes[best].name, foreseen[best].smallest)},
          {"best", changes[best].name},
          {"unit", foreseen[best].unit},
          {"changes", list}};
}

std::string predictionsCsv(const ForeseenLogChange& foreseen, const LogEvidence& evidence) {
  CsvWriter csv = predictionsOf(evidence, false);
  for (Eigen::Index i = 0; i < foreseen.time.size(); ++i) {
    csv.add(foreseen.time[i]);
    for (const Eigen::ArrayXd& predicted : foreseen.predicted) csv.add(predicted[i]);
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
