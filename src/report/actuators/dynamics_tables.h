/// \file
/// The tables of `fit-dynamics`, from result.json.
#pragma once

#include <string>

#include "simgap/report/table.h"

namespace simgap {

std::string dynamicsAnswer(const Json& result);
/// A joint per row: rows, noise, relative errors before and after.
Table dynamicsJoints(const Json& result);
Table dynamicsBodies(const Json& result);
Table dynamicsDrives(const Json& result);
/// Relative errors of `predict`, a joint per row.
Table robotPredictionJoints(const Json& result);
/// Of `predict --simulate`: how far the free motion is from the log's.
std::string robotMotionAnswer(const Json& result);
Table robotMotionJoints(const Json& result);
/// Base parameters with intervals.
Table dynamicsBase(const Json& result);

}  // namespace simgap
