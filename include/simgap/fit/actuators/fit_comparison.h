/// \file
/// Models of one log, fitted to the same rows and judged on others.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/holdout.h"

namespace simgap {

template <typename Fit>
struct FitCandidate {
  std::string name;
  Fit fit;
  std::optional<double> mse_heldout;  ///< in the squared unit of what is fitted

  double judgedError() const { return mse_heldout.value_or(fit.mse); }
};

template <typename Fit>
struct FitComparison {
  std::vector<FitCandidate<Fit>> candidates;  ///< not empty; simplest first
  std::size_t best = 0;
  std::string chosen_by = "lower held-out error";  ///< why it is the best, in words
  std::string heldout;                             ///< which rows, in words
  const FitCandidate<Fit>& chosen() const { return candidates[best]; }
  /// The richer model, the last, unless it gains nothing, or no more than its further numbers would by chance.
  /// \param doubt  why else it may not be; empty: it may
  void choose(std::string doubt) {
    const FitCandidate<Fit>&simple = candidates.front(), &rich = candidates.back();
    const bool gains = rich.judgedError() < simple.judgedError();
    if (doubt.empty() && gains && !outweighsItsNumbers(simple.fit, rich.fit)) {
      doubt = rich.name + " gains no more than its further parameter would by chance";
    }
    best = gains && doubt.empty() ? candidates.size() - 1 : 0;
    if (!chosen().mse_heldout) chosen_by = "lower error";
    if (gains && !doubt.empty()) chosen_by = std::move(doubt);
  }

 private:
  /// Schwarz' criterion, by as many rows as are independent: n ln(e_0 / e_1) > (p_1 - p_0) ln n.
  static bool outweighsItsNumbers(const Fit& simple, const Fit& rich) {
    const double n = rich.uncertainty.n_effective, further = static_cast<double>(rich.parameters - simple.parameters);
    return n * std::log(simple.mse / std::max(rich.mse, 1e-300)) > further * std::log(std::max(n, 1.0));
  }
};

/// \param fit_to  the fit to some rows, of shape (n); to all when they are empty. \param error_on  its mean squared
/// error on some.
template <typename FitTo, typename ErrorOn>
auto fitCandidate(const std::string& name, const JudgedRows& rows, const FitTo& fit_to, const ErrorOn& error_on) {
  FitCandidate<decltype(fit_to(rows.fitted))> candidate{name, fit_to(rows.fitted), std::nullopt};
  if (std::ranges::count(rows.fitted, false) == 0) return candidate;
  std::vector<bool> held = rows.fitted;
  held.flip();
  candidate.mse_heldout = error_on(candidate.fit, held);
  if (rows.then_all) candidate.fit = fit_to({});
  return candidate;
}

}  // namespace simgap
