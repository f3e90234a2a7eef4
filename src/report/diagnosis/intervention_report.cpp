#include "simgap/report/diagnosis/intervention_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "intervention_tables.h"
#include "simgap/core/csv.h"

namespace simgap {

Json toJson(const Intervention& result, const PoseEvidence& evidence, const ArmChanges& change) {
  Json candidates = Json::array();
  for (std::size_t c = 0; c < result.predictions.size(); ++c) {
    const CandidatePrediction& prediction = result.predictions[c];
    candidates.push_back({{"causes", evidence.candidates[c].causes},
                          {"role", evidence.candidates[c].role},
                          {"rms_deg", numberOrNull(prediction.rms)},
                          {"distance", prediction.distance},
                          {"freedom", prediction.freedom},
                          {"p", prediction.p},
                          {"log_odds_before", prediction.log_odds_before},
                          {"log_odds", prediction.log_odds},
                          {"without_equilibrium", prediction.without_equilibrium}});
  }
  return {{"format", "simgap/intervene/1"},      {"change", change.name},
          {"verdict", toString(result.verdict)}, {"sentence", result.sentence},
          {"poses", result.poses.size()},        {"poses_given", result.poses.size() + result.left_out.size()},
          {"left_out", result.left_out},         {"candidates", candidates}};
}

std::string predictionsCsv(const Intervention& result, const PoseEvidence& evidence, const PoseSet& after) {
  std::vector<std::string> header = {"pose", "joint"};
  for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
    header.push_back(fmt::format("{:02} {}", c, evidence.candidates[c].causes));
  }
  CsvWriter csv(header);
  const std::vector<Joint>& joints = evidence.given.joints;
  for (std::size_t i = 0; i < result.predictions.front().errors.size(); ++i) {
    csv.add(after.poses[i / joints.size()].name).add(joints[i % joints.size()].name);
    for (const CandidatePrediction& prediction : result.predictions) csv.add(prediction.errors[i]);
    csv.endRow();
  }
  return csv.text();
}

Json foreseenJson(const std::vector<ForeseenChange>& foreseen, const CandidateNames& candidates,
                  const std::vector<ArmChanges>& changes) {
  Json list = Json::array();
  std::size_t best = 0;
  for (std::size_t k = 0; k < foreseen.size(); ++k) {
    const ForeseenChange& change = foreseen[k];
    Json said = Json::array();
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      said.push_back({{"causes", candidates[c].first},
                      {"role", candidates[c].second},
                      {"largest_shift_deg", change.largest_shift[c]},
                      {"where", change.where[c]},
                      {"log_odds_if_named", change.log_odds[0][c]},
                      {"log_odds_if_this", change.log_odds[c][0]}});
    }
    list.push_back(
        {{"name", changes[k].name}, {"smallest_log_odds", numberOrNull(change.smallest)}, {"candidates", said}});
    if (change.smallest > foreseen[best].smallest) best = k;
  }
  return {{"format", "simgap/intervene/1"},
          {"verdict", "foreseen"},
          {"sentence", foreseenSentence(candidates.front().first, changes[best].name, foreseen[best].smallest)},
          {"best", changes[best].name},
          {"changes", list}};
}

Json toJson(const std::vector<ForeseenChange>& foreseen, const PoseEvidence& evidence,
            const std::vector<ArmChanges>& changes) {
  return foreseenJson(foreseen, namesOf(evidence.candidates), changes);
}

std::string interventionText(const Json& result) {
  return answerText(interventionAnswer(result), interventionTables(result));
}

}  // namespace simgap
