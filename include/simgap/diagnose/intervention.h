/// \file
/// The verdict on a cause after a change that was made on purpose: one way for poses and logs. Every model that a
/// diagnosis left standing has predicted the recording after the change with nothing refitted; the odds decide.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace simgap {

enum class InterventionVerdict { kConfirmed, kRefuted, kCannotTell };
std::string_view toString(InterventionVerdict verdict);

/// Log odds that decide: 20 to 1.
inline constexpr double kDecisiveLogOdds = 3.0;

/// What one candidate said of the recording after the change.
struct CandidateAnswer {
  std::string causes;
  double p = 0.0;         ///< of a distance as large, were the candidate right
  double log_odds = 0.0;  ///< against the named candidate, from what came after the change alone
  bool rival = false;     ///< contradicts the named one: it does not hold all its causes
};

struct Judgement {
  InterventionVerdict verdict = InterventionVerdict::kCannotTell;
  std::string sentence;
};

/// \param answers  the named candidate first. \param data  "poses", "rows": what was recorded
Judgement judgeCandidates(std::span<const CandidateAnswer> answers, std::string_view data);

}  // namespace simgap
