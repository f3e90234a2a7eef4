/// \file
/// What calibrate and validate share: reading their inputs, judging a model.
#pragma once

#include <string>

#include "simgap/cli/session.h"
#include "simgap/fit/poses/calibration_result.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {

ArmModel parseArm(const Input& input);
CalibrationConfig parseConfig(const Input& input);
/// The configuration that the user named, or the paper's that is built in.
Input readConfig(Session& session, const std::string& file);
PoseSet parsePoses(const Input& input, const ArmModel& model, const CsvOptions& options);

/// \param name  "bullet" or "equilibrium"
std::unique_ptr<Evaluator> makeEvaluator(const std::string& name, const PoseProtocol& protocol, int threads);

/// Judges a model on all poses of a set, with progress. \throws InterruptedError
Assessment replayAll(Evaluator& evaluator, const ArmModel& model, const PoseSet& set, const std::string& label,
                     bool quiet);

/// Says once per muscle that its cord was stretched beyond the range in which it is linear (000 eq. 2).
void warnAboutCords(std::span<const PoseOutcome> outcomes, const PoseLayout& layout);

/// Says which poses have other stable equilibria beside the one that the arm came to.
void warnAboutOtherEquilibria(const ArmModel& model, const PoseSet& set, std::span<const PoseOutcome> outcomes);

/// "2 of 15 poses are invalid: p003: …"
std::string describeInvalid(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout);

}  // namespace simgap
