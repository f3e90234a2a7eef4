/// \file
/// Drawn pose sets as a user would hand them in: through their files.
#pragma once

#include <string>
#include <vector>

#include "reality/pose_draws.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap::test {

/// configs/calibrate_arm.yaml.
const CalibrationConfig& paperConfig();
ArmModel modelOf(const reality::PoseDraw& draw);
PoseSet posesOf(const reality::PoseDraw& draw, const std::vector<reality::TimedPose>& poses);
PoseDiagnosis diagnose(const reality::PoseDraw& draw, const PoseDiagnosisOptions& options = {});
std::string labelOf(const std::string& effect, const std::string& target);

}  // namespace simgap::test
