/// \file
/// What a diagnosis of a log says at the end: what was found, what is left, and what to record next.
#pragma once

#include <string>

#include "log_evidence.h"
#include "log_selection.h"

namespace simgap {

/// The share of the error that is left, with the causes in the model, which a dependence without a name explains: the
/// unnamed one of the search, or forests. \param left  what forests explain
double shareLeft(const Selection& selection, const Ceiling& left);

/// Sets left_over_percent and the channels it depends on: shares of the baseline's error that add up.
/// \param left  what forests still explain with the causes in the model
void sayWhatIsLeft(const Selection& selection, const PreparedLog& log, const Ceiling& left, Diagnosis& d);

/// What is left over, and by which channel; empty when it is no structure.
std::string leftText(const Diagnosis& d);

/// Sets verdict and sentence. What was found is one statement, what is left another: nothing that was found is unsaid
/// because more is there.
void conclude(Diagnosis& d);

/// What to record next.
std::string nextExperiment(const Diagnosis& d, const PreparedLog& log);

}  // namespace simgap
