/// \file
/// Which causes a log calls for: forward steps while a further cause is significant, backward pruning, a review of each
/// cause against its rivals, and at last what is outside the catalogue.
#pragma once

#include <functional>

#include "log_hypotheses.h"

namespace simgap {

struct Selection {
  Fitted baseline;
  Fitted chosen;                   ///< with the named causes in order of acceptance, after the baseline's effects
  std::vector<Fitted> steps;       ///< shape (causes + 1): baseline, with one cause, with two …
  std::vector<double> p_adjusted;  ///< shape (causes)
  std::vector<std::vector<std::string>> ambiguous_with;  ///< shape (causes)
  std::vector<std::vector<Trial>> instead;               ///< shape (causes): what would have come next in its place
  std::optional<Trial> unnamed;                          ///< what a dependence outside the catalogue adds to `chosen`
  std::vector<Trial> last;           ///< the trials on top of `chosen`: for what could have been detected
  std::vector<std::string> aliased;  ///< effects that the model's own parameters can imitate exactly
  std::vector<HypothesisRecord> records;
};

/// Those of the trials that were measured and that `wanted` takes, the largest gain first.
template <class Wanted>
std::vector<const Trial*> byGain(const std::vector<Trial>& trials, const Wanted& wanted) {
  std::vector<const Trial*> some;
  for (const Trial& trial : trials) {
    if (trial.gain && wanted(trial)) some.push_back(&trial);
  }
  std::ranges::stable_sort(some, std::greater<>(), [](const Trial* trial) { return trial->gain->value; });
  return some;
}

/// Takes a cause out again; the later ones are refitted. \param own  effects of the baseline; \param cause  from 0
void dropCause(const LogSearch& search, std::size_t own, std::size_t cause, Selection& selection);

/// Compares each cause with its rivals again, and puts a better one in its place: after others were taken out.
void reviewCauses(const LogSearch& search, std::size_t own, const std::vector<Hypothesis>& hypotheses,
                  const LogDiagnosisOptions& options, Selection& selection);

/// \param hypotheses  named; \param unnamed  outside the catalogue
Selection selectCauses(const LogSearch& search, const std::vector<const ActuatorEffect*>& own,
                       const std::vector<Hypothesis>& hypotheses, const std::vector<Hypothesis>& unnamed,
                       const LogDiagnosisOptions& options, const DiagnosisProgress& progress);

}  // namespace simgap
