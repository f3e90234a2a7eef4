/// \file
/// Which channel of a pneumatic muscle's log has the wrong sign.
#pragma once

#include <string>

#include "simgap/measure/logs/actuator_log.h"

namespace simgap {

/// A sentence about the force or the contraction when turning it round leaves less than half of the squared error that
/// a muscle leaves as they are; empty when neither does. Judged by a rigid tendon's (002 eq. 12)
///
///     f = p (a eps^2 - b eps + c) + offset,     a, b, c >= 0
///
/// less the same of a muscle that opposes it. Of a joint's log fits judge the angle (fitPam): it is no
/// contraction, and a rigid tendon is too coarse for it.
std::string oppositePamSign(const PamLog& log);

}  // namespace simgap
