/// \file
/// Friction that grows with a known load. Under a law without such a term a cause may stand in for it: a Stribeck curve
/// whose size is per load, what changes where the load does. It has to hold beside it.
#pragma once

#include <optional>

#include "log_hypotheses.h"

namespace simgap {

/// A part of a law that differs from a simpler one by friction that goes with the load alone.
bool isByTheLoad(const ActuatorEffect& effect);

/// Whether the law has no friction by a load that is known, and the cause is not that friction. Not so for a gearbox.
bool lacksLoadFriction(const LogSearch& search, const ActuatorEffect& cause);

/// Whether a cause with a constant part and one by the load is the latter, first of all, where the law lacks friction
/// by the load: then any such friction may be it.
bool isMostlyByTheLoad(const LogSearch& search, const Fitted& full, std::size_t effect);

/// Two models, each with dry friction by the load, in proportion to it and to its square, beside it.
/// \param full, rest  a model with a cause and without it. None unless lacksLoadFriction().
std::optional<Beside> besideLoadFriction(const LogSearch& search, const Fitted& rest, const Fitted& full,
                                         const ActuatorEffect& cause);

}  // namespace simgap
