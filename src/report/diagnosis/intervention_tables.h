/// \file
/// The tables of `intervene`, from result.json.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "simgap/intervene/intervention.h"
#include "simgap/model/arm/arm_change.h"
#include "simgap/report/table.h"

namespace simgap {

/// Causes and role of every candidate.
using CandidateNames = std::vector<std::pair<std::string, std::string>>;
template <class Candidate>
CandidateNames namesOf(const std::vector<Candidate>& candidates) {
  CandidateNames names;
  for (const Candidate& candidate : candidates) names.emplace_back(candidate.causes, candidate.role);
  return names;
}
/// What changes of an arm would tell. \param changes  shape (foreseen)
Json foreseenJson(const std::vector<ForeseenChange>& foreseen, const CandidateNames& candidates,
                  const std::vector<ArmChanges>& changes);

/// The change that would tell most, or that none would. \param log_odds  expected, the smallest of any rival
std::string foreseenSentence(const std::string& named, const std::string& change, double log_odds);
std::string interventionAnswer(const Json& result);
std::vector<Table> interventionTables(const Json& result);

}  // namespace simgap
