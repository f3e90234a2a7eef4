#include "likely_causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace simgap {

void addLikely(const Selection& selection, Diagnosis& d) {
  constexpr double kWorthSaying = 0.1;  // of the error
  constexpr double kMostP = 0.1;        // of the hypothesis alone
  constexpr double kSmallestP = 1e-3;
  constexpr std::size_t kMost = 3;
  const auto likely = [&](const Trial& trial) {
    const bool found = std::ranges::find(d.causes, trial.hypothesis.effect->name, &Cause::effect) != d.causes.end();
    return !found && trial.gain->value >= kWorthSaying && trial.p_paired < kMostP;
  };
  for (const Trial* trial : byGain(selection.last, likely)) {
    const std::string name(trial->hypothesis.effect->name);
    if (std::ranges::find(d.candidates, name, &Candidate::effect) != d.candidates.end()) continue;
    if (d.candidates.size() >= kMost) break;
    // At best p argues by that much against chance (Sellke, Bayarri & Berger 2001).
    const double p = std::max(trial->p_paired, kSmallestP);
    const double odds = 1.0 / (-std::numbers::e * p * std::log(p));
    d.candidates.push_back(
        {name,
         {},
         fmt::format("likely, not certain: odds of at best {:.0f} : 1 (p = {:.2g}), and {} causes were "
                     "tried; a longer log would tell",
                     odds, trial->p_paired, selection.last.size()),
         *trial->gain});
  }
}

}  // namespace simgap
