/// \file
/// The half of `diagnose` that takes poses of an arm.
#pragma once

#include <string>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"

namespace simgap {

struct PoseDiagnosisInputs {
  std::string model, poses, config;
  std::string holdout;  ///< a fraction; empty: the default
};

ExitCode diagnosePoseFile(Session& session, const PoseDiagnosisInputs& inputs, const CsvOptions& csv,
                          const CommonOptions& common, PoseDiagnosisOptions options);

}  // namespace simgap
