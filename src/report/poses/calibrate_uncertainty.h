/// \file
/// The parts of calibrate's report on uncertainty, and on two evaluators' views of one model.
#pragma once

#include "simgap/report/poses/pose_report.h"

namespace simgap {

Json uncertaintyJson(const CalibrationResult& result);

/// How far the evaluator that searched and the one that judged disagree; nothing when they are the same.
Json verificationJson(const CalibrationResult& result);

}  // namespace simgap
