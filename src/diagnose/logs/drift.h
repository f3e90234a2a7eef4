/// \file
/// Friction and effort that drift over the log: an amplifier that warms up, a sensor whose zero wanders, friction that
/// follows a humidity nobody logged. What a change at one moment has to explain more than.
#pragma once

#include "log_hypotheses.h"

namespace simgap {

/// The model with friction that wanders, a broken line over the time of the log, and an effort of c + d u beside it.
Fitted besideDrift(const LogSearch& search, const Fitted& rest);

}  // namespace simgap
