/// \file
/// The verdict on a cause after a change that was made on purpose: one way for poses and logs. Every model that a
/// diagnosis left standing has predicted the recording after the change with nothing refitted; the odds decide.
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace simgap {

enum class InterventionVerdict { kConfirmed, kRefuted, kCannotTell };
std::string_view toString(InterventionVerdict verdict);

/// Log odds that decide: 20 to 1.
inline constexpr double kDecisiveLogOdds = 3.0;

/// Odds to be read: from exp(300) on they all mean the same.
inline double oddsOf(double log_odds) { return std::exp(std::min(log_odds, 300.0)); }

/// "odds 31.5 to 1"; "odds beyond 1e+09 to 1"
std::string saidOdds(double log_odds);

/// The causes that each candidate holds, the named one first: "payload:forearm".
using HeldCauses = std::vector<std::set<std::string>>;

/// Which candidates contradict the named one, shape (candidates): one that holds all its causes and more does not,
/// unless nothing was named.
std::vector<bool> rivalsOf(const HeldCauses& held);

/// Undoing what no model holds changes nothing in any of them. \param cause  empty: nothing is undone
/// \throws ConfigError: no candidate holds it.
void requireHeld(const HeldCauses& held, const std::string& cause);

/// What a change of an arm would tell.
struct ForeseenChange {
  /// shape (candidates, candidates): expected log odds of the row's candidate over the column's, were the row's right
  std::vector<std::vector<double>> log_odds;
  double smallest = 0.0;              ///< of the named candidate against any that contradicts it, either of them right
  std::vector<double> largest_shift;  ///< shape (candidates) [deg], of a slide [mm]: furthest from the named one's
  std::vector<std::string> where;     ///< shape (candidates): joint, and pose or second, of it
};

/// What one candidate said of the recording after the change.
struct CandidateAnswer {
  std::string causes;
  double p = 0.0;         ///< of a distance as large, were the candidate right
  double log_odds = 0.0;  ///< against the named candidate, from what came after the change alone
  bool rival = false;     ///< contradicts the named one: it does not hold all its causes
  double before = 0.0;    ///< the same odds from the data before the change
  bool refused = false;   ///< the diagnosis looked at it and did not accept it
};

struct Judgement {
  InterventionVerdict verdict = InterventionVerdict::kCannotTell;
  std::string sentence;
};

/// \param answers  the named candidate first. \param data  "poses", "rows": what was recorded
Judgement judgeCandidates(std::span<const CandidateAnswer> answers, std::string_view data);

}  // namespace simgap
