/// \file
/// The results of `calibrate` and `validate` as JSON (docs/formats.md), CSV and a table for the terminal.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/poses/calibration_run.h"
#include "simgap/report/table.h"

namespace simgap {

/// A limit the user set on a result.
struct Criterion {
  std::string name;  ///< "shoulder mje_deg"
  double limit;
  double value;
  bool pass() const { return value <= limit; }  // NaN does not pass
};

struct ValidationResult {
  PoseLayout layout;
  PoseSet set;
  Assessment assessment;
  std::vector<Criterion> criteria;
};

/// \name calibrate
///@{
Json toJson(const CalibrationResult& result);
std::string historyCsv(const CalibrationResult& result);
std::string parametersCsv(const CalibrationResult& result);
std::string errorsCsv(const CalibrationResult& result);  ///< set, pose, status and error before and after, per joint
std::string singularValuesCsv(const CalibrationResult& result);
/// What the poses tell of the parameters, what error to expect on others; lines for the terminal.
/// \param result  of toJson, or as much of it as a plan has
std::string uncertaintyText(const Json& result);
std::string terminalTable(const CalibrationResult& result);
/// What a calibration would do, and what its poses can tell before any is run. \param expected  by expectedResult
std::string planText(const CalibrationTask& task, const CalibrationResult& expected);
/// model.yaml, the tables, and the geometry of both models at all poses (writeArmGeometry).
void writeCalibration(const ArmModel& before, const ArmModel& after, const CalibrationResult& result,
                      const RunDirectory& directory);
///@}

/// \name validate
///@{
Json toJson(const ValidationResult& result);
std::string errorsCsv(const ValidationResult& result);
std::string terminalTable(const ValidationResult& result);
///@}

}  // namespace simgap
