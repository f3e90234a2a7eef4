/// \file
/// The result of `predict --joint-angle` as JSON, CSV and lines for the terminal (docs/formats.md).
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/actuators/joint_stretch.h"
#include "simgap/report/table.h"

namespace simgap {

/// That of `predict`, with what the cable does to the angle.
Json toJson(const JointStretch& stretch, const std::string& kind);
/// load_Nm, joint_position_rad, rows, stretch_rad, model_rad of every cell with rows
std::string stretchCsv(const JointStretch& stretch);
std::string stretchAnswer(const Json& result);
Table stretchTable(const Json& result);

}  // namespace simgap
