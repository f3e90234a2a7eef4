/// \file
/// The tables of the capture commands, from result.json.
#pragma once

#include <string>
#include <vector>

#include "simgap/report/html/result_files.h"

namespace simgap {

/// \name capture
///@{
/// \param poses  how many there are
std::string captureAnswer(const Json& result, std::size_t poses);
Table sightingTable(const Json& result);  ///< how well each target was seen
Table captureFigures(const Json& result);
inline constexpr std::size_t kMostPosesShown = 500;
/// What is not in a table of the first ones.
std::string morePoses(std::size_t poses);
/// When the arm rested, and where. \param poses  poses.csv, of as many rows as `result` has poses
Table poseTable(const Json& result, const CsvTable& poses);
/// A joint's angle in every row, of a spherical joint that from its zero pose [deg]. \param table  poses.csv,
/// joints.csv
std::vector<double> jointAngles(const CsvTable& table, const std::string& joint);
///@}

/// \name calibrate-cameras
///@{
std::string cameraAnswer(const Json& result);
Table cameraFigures(const Json& result);
Table cameraParameters(const Json& result);
///@}

/// \name calibrate-joints
///@{
std::string jointAnswer(const Json& result);
Table jointTable(const Json& result);
///@}

/// \name targets check
///@{
std::string targetAnswer(const Json& result);
Table targetTable(const Json& result);  ///< what each target could be confused with; "!": noise could bridge it
Table crossTable(const Json& result);   ///< targets against each other
///@}

}  // namespace simgap
