/// \file
/// Which motion spoke for the causes of a diagnosis.
#pragma once

#include "simgap/core/run_directory.h"
#include "simgap/report/table.h"

namespace simgap {

/// \param result  a diagnosis of motions; root mean squares in standard deviations of the noise
Table motionSays(const Json& result);

}  // namespace simgap
