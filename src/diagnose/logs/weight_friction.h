/// \file
/// Friction that grows with a weight that is fitted. The weight of a pendulum goes with its angle, and where it is
/// fitted no load is known by which `load-dependence` could be asked for: what follows the angle has to hold beside it.
#pragma once

#include <optional>

#include "log_hypotheses.h"

namespace simgap {

/// Two models, each with dry friction in proportion to the size of the weight beside it.
/// \param full, rest  a model with a cause and without it. None where no weight is fitted.
std::optional<Beside> besideWeightFriction(const LogSearch& search, const Fitted& rest, const Fitted& full);

}  // namespace simgap
