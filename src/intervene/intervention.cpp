#include "simgap/intervene/intervention.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>

#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr double kImprobable = 1e-3;  // of a distance, were the candidate right: it is refuted
constexpr double kDoubtful = 1e-2;    // and no longer confirmed
constexpr double kBeyondDoubt = 1e9;  // odds of which nobody needs the number

/// What is added to the named causes has to be worth it with what was recorded before, too: there it was not.
double oddsOfAll(const CandidateAnswer& answer) {
  return answer.rival ? answer.log_odds : answer.log_odds + std::min(0.0, answer.before);
}

}  // namespace

std::string saidOdds(double log_odds) {
  const double odds = oddsOf(log_odds);
  return odds > kBeyondDoubt ? fmt::format("odds beyond {:.0e} to 1", kBeyondDoubt)
                             : fmt::format("odds {:.3g} to 1", odds);
}

namespace {

/// Those that predict as well as the best, up to odds that decide nothing; the best first.
std::string likeBest(std::span<const CandidateAnswer> answers, std::size_t best) {
  std::string names = answers[best].causes;
  for (std::size_t c = 1; c < answers.size(); ++c) {
    const bool close = oddsOfAll(answers[best]) - oddsOfAll(answers[c]) < kDecisiveLogOdds;
    if (c != best && answers[c].rival && close && answers[c].p >= kDoubtful) names += " or " + answers[c].causes;
  }
  return names;
}

/// A rival that says as much as the best of all data, those before the change as well; the best itself without one.
std::size_t rivalAsGood(std::span<const CandidateAnswer> answers, std::size_t best) {
  const auto all = [&](std::size_t c) { return answers[c].log_odds + answers[c].before; };
  std::size_t found = best;
  for (std::size_t c = 1; c < answers.size(); ++c) {
    const bool good = answers[c].rival && answers[c].p >= kImprobable && answers[c].log_odds > kDecisiveLogOdds;
    if (good && all(c) > all(best) - kDecisiveLogOdds && (found == best || all(c) > all(found))) found = c;
  }
  return found;
}

/// The named candidate is beaten by `best`. A law leaves a little that a cause which is not there can take up, and many
/// rows make any odds of it: what the diagnosis refused refutes no model that predicts the recording as well as it
/// should.
Judgement refutation(std::span<const CandidateAnswer> answers, std::size_t best, std::string_view data) {
  const CandidateAnswer &named = answers.front(), &better = answers[best];
  const std::string odds = saidOdds(better.log_odds);
  if (better.p < kDoubtful) {
    return {InterventionVerdict::kCannotTell,
            fmt::format("{} comes nearer to these {} than {} ({}), and yet not near enough (p {:.2g}): what was "
                        "changed, or what is wrong, is not what any of {} models says",
                        better.causes, data, named.causes, odds, better.p, answers.size())};
  }
  if (named.p < kDoubtful) {
    return {InterventionVerdict::kRefuted,
            fmt::format("{} predicts these {}, {} does not ({})", likeBest(answers, best), data, named.causes, odds)};
  }
  if (better.refused) {
    return {InterventionVerdict::kCannotTell,
            fmt::format("{} comes nearer to these {} than {} ({}), but {} predicts them, too, and the diagnosis has "
                        "refused {}",
                        better.causes, data, named.causes, odds, named.causes, better.causes)};
  }
  return {InterventionVerdict::kRefuted,
          fmt::format("{} predicts these {} better than {} ({})", likeBest(answers, best), data, named.causes, odds)};
}

}  // namespace

std::string_view toString(InterventionVerdict verdict) {
  switch (verdict) {
    case InterventionVerdict::kConfirmed:
      return "confirmed";
    case InterventionVerdict::kRefuted:
      return "refuted";
    case InterventionVerdict::kCannotTell:
      break;
  }
  return "cannot-tell";
}

std::vector<bool> rivalsOf(const HeldCauses& held) {
  const std::set<std::string>& named = held.front();
  std::vector<bool> rivals = {false};
  for (const std::set<std::string>& other : std::span(held).subspan(1)) {
    rivals.push_back(named.empty() || !std::ranges::includes(other, named));
  }
  return rivals;
}

void requireHeld(const HeldCauses& held, const std::string& cause) {
  std::set<std::string> any;
  for (const std::set<std::string>& causes : held) any.insert(causes.begin(), causes.end());
  if (cause.empty() || any.contains(cause)) return;
  throw ConfigError(fmt::format("found '{}' to undo, which no model of the diagnosis holds; expected one of {}", cause,
                                any.empty() ? "none: nothing was found" : fmt::format("{}", fmt::join(any, ", "))));
}

Judgement judgeCandidates(std::span<const CandidateAnswer> answers, std::string_view data) {
  const CandidateAnswer& named = answers.front();
  std::size_t best = 0;
  double runner_up = -std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < answers.size(); ++c) {
    if (oddsOfAll(answers[c]) > oddsOfAll(answers[best])) best = c;
    if (answers[c].rival) runner_up = std::max(runner_up, answers[c].log_odds);
  }
  const CandidateAnswer& first = answers[best];
  if (first.p < kImprobable) {
    return {InterventionVerdict::kCannotTell,
            fmt::format("none of {} models predicts these {}: what was changed, or what is wrong, is not what any of "
                        "them says",
                        answers.size(), data)};
  }
  // That others with the same causes and more predict better speaks for these as well.
  if (named.p >= kDoubtful && runner_up < -kDecisiveLogOdds) {
    return {InterventionVerdict::kConfirmed,
            fmt::format("{} predicts these {} with nothing refitted, and no model without it does ({})", named.causes,
                        data, saidOdds(-runner_up))};
  }
  const bool named_fails = oddsOfAll(first) > kDecisiveLogOdds || named.p < kImprobable;
  // Another with the same causes is no refutation of them, unless one without them says as much.
  if (named_fails && best > 0 && !first.rival) best = rivalAsGood(answers, best);
  if (named_fails && best > 0 && !answers[best].rival) {
    return {InterventionVerdict::kCannotTell, fmt::format("{} predicts these {} better than {} alone ({})",
                                                          first.causes, data, named.causes, saidOdds(first.log_odds))};
  }
  if (named_fails) return refutation(answers, best, data);
  if (runner_up < -kDecisiveLogOdds) {
    return {InterventionVerdict::kCannotTell,
            fmt::format("{} comes nearest to these {} ({}), and yet not near enough (p {:.2g}): its size, or something "
                        "beside it, is not what the diagnosis says",
                        named.causes, data, saidOdds(-runner_up), named.p)};
  }
  return {InterventionVerdict::kCannotTell,
          fmt::format("these {} do not tell {} from the other models: after this change all predict much the same",
                      data, named.causes)};
}

}  // namespace simgap
