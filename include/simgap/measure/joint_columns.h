/// \file
/// Columns of joints in measured tables.
#pragma once

#include "simgap/core/csv.h"
#include "simgap/measure/pose_set.h"

namespace simgap {

/// \throws DataError: the table holds a joint's position as another kind of joint has it, so it belongs to a model of
///         that kind.
void refuseOtherJointTypes(const CsvTable& table, const PoseLayout& layout);

}  // namespace simgap
