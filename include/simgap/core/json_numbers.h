/// \file
/// Numbers of JSON that somebody may have edited.
#pragma once

#include "simgap/core/run_directory.h"

namespace simgap {

/// A whole number; get<long>() would cast whatever number stands there, which of 1e308 is undefined.
/// \throws Json::type_error, as get() does: something else, or one beyond 2^53
long wholeNumber(const Json& json);

}  // namespace simgap
