/// \file
/// The results of `calibrate --motions` and `validate --motions` as JSON (docs/formats.md), CSV and tables.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "simgap/report/poses/pose_report.h"
#include "simgap/report/table.h"

namespace simgap {

/// A model judged on a motion set.
struct MotionValidationResult {
  PoseLayout layout;
  MotionSet set;
  std::vector<PlayedMotion> played;
  MotionNoise noise;
  MotionRms rms;
  std::vector<Criterion> criteria;
};

/// \name validate
///@{
Json toJson(const MotionValidationResult& result);
std::string terminalTable(const MotionValidationResult& result);
/// motion, channel, rms, noise, worst second, lag: a row per motion and channel
std::string motionErrorsCsv(const MotionValidationResult& result);
///@}

/// \name calibrate
///@{
Json toJson(const MotionCalibrationResult& result);
std::string terminalTable(const MotionCalibrationResult& result);
std::string motionParametersCsv(const MotionCalibrationResult& result);
std::string motionHistoryCsv(const MotionCalibrationResult& result);
/// model.yaml and all tables.
void writeMotionCalibration(const MotionCalibrationResult& result, const RunDirectory& directory);
///@}

/// Motions as one model played them, named as a page shows them.
struct PlayedSet {
  std::string set;    ///< "calibration"
  std::string model;  ///< "before", "after", "simulated"
  const MotionSet* motions;
  const std::vector<PlayedMotion>* played;
};
/// Joint errors over time: set, motion, model, joint, unit, time_s, error (its size; of a ball the angle).
std::string residualsCsv(const PoseLayout& layout, const std::vector<PlayedSet>& sets);

}  // namespace simgap
