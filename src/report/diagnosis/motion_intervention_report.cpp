#include "simgap/report/diagnosis/motion_intervention_report.h"

#include <fmt/format.h>

#include <cmath>

#include "intervention_tables.h"
#include "simgap/core/csv.h"

namespace simgap {

Json toJson(const MotionIntervention& result, const MotionEvidence& evidence, const ArmChanges& change,
            const MotionSet& after) {
  Json candidates = Json::array();
  for (std::size_t c = 0; c < result.predictions.size(); ++c) {
    const PlayedCandidate& prediction = result.predictions[c];
    candidates.push_back({{"causes", evidence.candidates[c].causes},
                          {"role", evidence.candidates[c].role},
                          {"rms_sd", numberOrNull(prediction.rms)},
                          {"left_sd", numberOrNull(prediction.left)},
                          {"p", prediction.p},
                          {"p_left", prediction.p_left},
                          {"p_way", prediction.p_way},
                          {"log_odds_before", evidence.candidates[c].log_odds},
                          {"log_odds", prediction.log_odds},
                          {"not_played", prediction.lost}});
  }
  return {{"format", "simgap/intervene/1"},
          {"of", "motions"},
          {"change", change.name},
          {"verdict", toString(result.verdict)},
          {"sentence", result.sentence},
          {"motions", after.motions.size()},
          {"motions_given", after.motions.size()},
          {"candidates", candidates}};
}

std::string predictionsCsv(const MotionIntervention& result, const MotionEvidence& evidence, const MotionSet& after) {
  std::vector<std::string> header = {"motion", "channel"};
  for (std::size_t c = 0; c < evidence.candidates.size(); ++c) {
    header.push_back(fmt::format("{:02} {}", c, evidence.candidates[c].causes));
  }
  CsvWriter csv(header);
  const std::vector<Joint>& joints = evidence.given.joints;
  for (std::size_t m = 0; m < after.motions.size(); ++m) {
    for (std::size_t g = 0; g < joints.size() + 2; ++g) {
      csv.add(after.motions[m].name);
      csv.add(g < joints.size() ? joints[g].name : std::string(g == joints.size() ? "shafts" : "currents"));
      for (const PlayedCandidate& prediction : result.predictions) {
        csv.add(std::sqrt(prediction.squares(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(m))));
      }
      csv.endRow();
    }
  }
  return csv.text();
}

Json toJson(const std::vector<ForeseenChange>& foreseen, const MotionEvidence& evidence,
            const std::vector<ArmChanges>& changes) {
  Json json = foreseenJson(foreseen, namesOf(evidence.candidates), changes);
  json["of"] = "motions";
  return json;
}

}  // namespace simgap
