#include "simgap/report/diagnosis/separation_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "separation_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/joint_kind.h"
#include "simgap/diagnose/intervention.h"

namespace simgap {
namespace {

/// Even ones at least: nothing that is recorded is expected to speak for the wrong model.
double promisedOdds(double log_odds) { return oddsOf(std::max(log_odds, 0.0)); }

/// The model that a protocol tells from the named one worst.
std::string nearestOf(const ForeseenLogChange& foreseen, const LogEvidence& evidence) {
  for (std::size_t c = 1; c < evidence.candidates.size(); ++c) {
    const double least = std::min(foreseen.log_odds[0][c], foreseen.log_odds[c][0]);
    if (least == foreseen.smallest) return evidence.candidates[c].known.causes;
  }
  return "-";
}

}  // namespace

Json toJson(const PoseSeparation& result, const PoseEvidence& evidence) {
  const std::string& named = evidence.candidates.front().causes;
  Json rivals = Json::array();
  for (std::size_t k = 0; k + 1 < result.pairs.size(); k += 2) {
    const CandidateModel& rival = evidence.candidates[result.pairs[k].wrong];
    rivals.push_back({{"causes", rival.causes},
                      {"role", rival.role},
                      {"log_odds_before", -rival.log_odds},
                      {"promised_if_named", result.pairs[k].log_odds},
                      {"promised_if_this", result.pairs[k + 1].log_odds}});
  }
  Json poses = Json::array();
  for (const Pose& pose : result.poses) {
    Json shafts = Json::object();
    for (std::size_t m = 0; m < evidence.given.muscles.size(); ++m) {
      shafts[evidence.given.muscles[m].name] = pose.shafts[m];
    }
    poses.push_back({{"pose", pose.name}, {"shaft_rad", shafts}});
  }
  return {
      {"format", "simgap/separate/1"},
      {"sentence",
       fmt::format("These {} poses are expected to tell {} from every model that contradicts it by odds "
                   "of {:.3g} to 1 at least, whichever is right; as many random ones by {:.3g} to 1",
                   result.poses.size(), named, promisedOdds(result.promised), promisedOdds(result.promised_random))},
      {"named", named},
      {"recorded", evidence.poses.size()},
      {"promised", result.promised},
      {"promised_random", result.promised_random},
      {"smallest", result.smallest},
      {"smallest_random", result.smallest_random},
      {"rivals", rivals},
      {"poses", poses}};
}

std::string nextPosesCsv(const PoseSeparation& result, const ArmModel& model) {
  std::vector<std::string> columns{"pose"};
  for (const Muscle& muscle : model.muscles) columns.push_back("shaft_" + muscle.name + "_rad");
  for (const Joint& joint : model.joints) {
    for (std::string& column : positionColumns(joint.type, joint.name)) columns.push_back(std::move(column));
  }
  CsvWriter csv(columns);
  for (const Pose& pose : result.poses) {
    csv.add(pose.name);
    for (const double shaft : pose.shafts) csv.add(shaft);
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      for (const double cell : kindOf(model.joints[j].type).cells(pose.joints[j])) csv.add(cell);
    }
    csv.endRow();
  }
  return csv.text();
}

const LogProtocol& bestOf(const std::vector<LogProtocol>& protocols) {
  return *std::ranges::max_element(protocols, {}, [](const LogProtocol& p) { return p.foreseen.smallest; });
}

Json toJson(const std::vector<LogProtocol>& protocols, const LogEvidence& evidence) {
  Json list = Json::array();
  for (const LogProtocol& protocol : protocols) {
    list.push_back({{"speed", protocol.speed},
                    {"load", protocol.load},
                    {"smallest_log_odds", numberOrNull(protocol.foreseen.smallest)},
                    {"nearest", nearestOf(protocol.foreseen, evidence)}});
  }
  const LogProtocol& best = bestOf(protocols);
  const std::string& named = evidence.candidates.front().known.causes;
  return {
      {"format", "simgap/separate/1"},
      {"sentence",
       fmt::format("The motion {:g} times as fast under {:g} times the load is expected to tell {} from every model "
                   "that contradicts it by odds of {:.3g} to 1 at least, whichever is right",
                   best.speed, best.load, named, promisedOdds(best.foreseen.smallest))},
      {"named", named},
      {"unit", best.foreseen.unit},
      {"best", {{"speed", best.speed}, {"load", best.load}}},
      {"protocols", list}};
}

std::string separationText(const Json& result) {
  return answerText(separationAnswer(result), separationTables(result));
}

}  // namespace simgap
