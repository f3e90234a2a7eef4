/// \file
/// What a short log makes likely and cannot confirm.
#pragma once

#include "log_selection.h"

namespace simgap {

/// Causes that a short log makes likely, but not certain, join the candidates, with their odds.
void addLikely(const Selection& selection, Diagnosis& d);

}  // namespace simgap
