#include "simgap/report/diagnosis/separation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "intervention_tables.h"
#include "separation_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/intervene/intervention.h"

namespace simgap {
namespace {

/// "odds 31.5 to 1 at least"; even ones are none: nothing that is recorded is expected to speak for the wrong model.
std::string promisedOdds(double log_odds) {
  constexpr double kEven = 0.05;
  return log_odds < kEven ? "nothing" : saidOdds(log_odds) + " at least";
}

/// The model that a protocol tells from the named one worst. \tparam Foreseen  with log_odds and smallest
template <class Foreseen>
std::string nearestOf(const Foreseen& foreseen, const CandidateNames& candidates) {
  for (std::size_t c = 1; c < candidates.size(); ++c) {
    const double least = std::min(foreseen.log_odds[0][c], foreseen.log_odds[c][0]);
    if (least == foreseen.smallest) return candidates[c].first;
  }
  return "-";
}

Json beyondOrNull(const std::string& beyond) { return beyond.empty() ? Json(nullptr) : Json(beyond); }

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
  return {{"format", "simgap/separate/1"},
          {"sentence", fmt::format("{} {} poses are expected to tell {} from every model that contradicts it by {}, "
                                   "whichever is right; as many random ones by {}",
                                   result.promised > kDecisiveLogOdds ? "These" : "Not even these", result.poses.size(),
                                   named == "none" ? "the model without a cause" : named, promisedOdds(result.promised),
                                   promisedOdds(result.promised_random))},
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

std::string beyondLimits(const ForeseenLogChange& foreseen, const MotionLimits& limits) {
  double duration = 0.0;  // of sessions one after the other
  for (Eigen::Index i = 1; i < foreseen.time.size(); ++i) {
    duration += std::max(0.0, foreseen.time[i] - foreseen.time[i - 1]);
  }
  if (duration > limits.duration) return fmt::format("{:.3g} s", duration);
  if (!std::isfinite(limits.current)) return "";
  if (foreseen.unit != "A") {
    throw ConfigError(fmt::format(
        "found --max-current-A, expected it with a log of currents: the effort of this one is in {}", foreseen.unit));
  }
  const double largest = foreseen.predicted.front().abs().maxCoeff();
  return largest > limits.current ? fmt::format("{:.3g} A", largest) : "";
}

const LogProtocol& bestOf(const std::vector<LogProtocol>& protocols) {
  const LogProtocol& best = *std::ranges::max_element(
      protocols, {}, [](const LogProtocol& p) { return std::pair(p.beyond.empty(), p.foreseen.smallest); });
  if (best.beyond.empty()) return best;
  throw ConfigError(
      fmt::format("every motion is beyond the limits (speed x {:g}, load x {:g}: {}), expected one within",
                  protocols.front().speed, protocols.front().load, protocols.front().beyond));
}

Json toJson(const std::vector<LogProtocol>& protocols, const LogEvidence& evidence) {
  CandidateNames names;
  for (const LogEvidence::Candidate& one : evidence.candidates) names.emplace_back(one.known.causes, one.known.role);
  Json list = Json::array();
  for (const LogProtocol& protocol : protocols) {
    list.push_back({{"speed", protocol.speed},
                    {"load", protocol.load},
                    {"smallest_log_odds", numberOrNull(protocol.foreseen.smallest)},
                    {"nearest", nearestOf(protocol.foreseen, names)},
                    {"beyond", beyondOrNull(protocol.beyond)}});
  }
  const LogProtocol& best = bestOf(protocols);
  const std::string& named = evidence.candidates.front().known.causes;
  return {{"format", "simgap/separate/1"},
          {"sentence",
           fmt::format("{} motion {:g} times as fast under {:g} times the load is expected to tell {} from every model "
                       "that contradicts it by {}, whichever is right",
                       best.foreseen.smallest > kDecisiveLogOdds ? "The" : "Not even the", best.speed, best.load, named,
                       promisedOdds(best.foreseen.smallest))},
          {"named", named},
          {"unit", best.foreseen.unit},
          {"best", {{"speed", best.speed}, {"load", best.load}}},
          {"protocols", list}};
}

std::string nextMotionFile(int chosen) { return fmt::format("next_{}.csv", chosen); }

Json toJson(const MotionSeparation& result, const MotionEvidence& evidence) {
  const CandidateNames names = namesOf(evidence.candidates);
  Json list = Json::array();
  for (const MotionProtocol& protocol : result.protocols) {
    list.push_back(
        {{"motion", protocol.motion.name},
         {"speed", protocol.speed},
         {"smallest_log_odds", protocol.beyond.empty() ? numberOrNull(protocol.foreseen.smallest) : Json(nullptr)},
         {"nearest", protocol.beyond.empty() ? nearestOf(protocol.foreseen, names) : "-"},
         {"beyond", beyondOrNull(protocol.beyond)},
         {"record", protocol.chosen > 0 ? Json(nextMotionFile(protocol.chosen)) : Json(nullptr)}});
  }
  const double promised = result.smallest.back();
  const std::string last = nextMotionFile(static_cast<int>(result.smallest.size())),
                    files = result.smallest.size() == 1 ? last : nextMotionFile(1) + " to " + last,
                    odds = promisedOdds(promised);
  const std::string sentence =
      promised > kDecisiveLogOdds
          ? fmt::format(
                "The commands of {} are expected to tell {} from every model that contradicts it by {}, "
                "whichever is right",
                files, names.front().first, odds)
          : fmt::format("Not even the commands of {} are expected to tell {} from every model that contradicts it: {}",
                        files, names.front().first, odds);
  return {{"format", "simgap/separate/1"},
          {"of", "motions"},
          {"sentence", sentence},
          {"named", names.front().first},
          {"promised", promised},
          {"smallest", result.smallest},
          {"protocols", list}};
}

std::string separationText(const Json& result) {
  return answerText(separationAnswer(result), separationTables(result));
}

}  // namespace simgap
