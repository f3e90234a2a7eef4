/// \file
/// Friction that grows with a known load. Under a law without such a term a cause may stand in for it: a Stribeck curve
/// whose size is per load, what changes where the load does. It has to hold beside it.
#pragma once

#include <optional>

#include "log_hypotheses.h"

namespace simgap {

/// Two models, each with dry friction by the load, in proportion to it and to its square, beside it.
struct BesideLoad {
  Fitted rest, full;
};

/// \param full, rest  a model with a cause and without it. None for a gearbox, where the law has friction by the load,
/// where no load is known, and for a cause that is this friction.
std::optional<BesideLoad> besideLoadFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                             const ActuatorEffect& cause);

}  // namespace simgap
