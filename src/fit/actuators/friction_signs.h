/// \file
/// Which channel of a drive's log has the wrong sign.
#pragma once

#include <string>

#include "simgap/measure/logs/friction_rows.h"

namespace simgap {

/// A sentence about the effort, the load or the velocity when turning it round leaves less than half of the squared
/// error that load and friction leave as they are; empty when none does. Judged by
///
///     effort = c_0 load + c_1 |load| sign(w) + c_2 sign(w) + c_3 w + offset,     c_0 … c_3 >= 0
std::string oppositeSign(const FrictionData& data);

}  // namespace simgap
