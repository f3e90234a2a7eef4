/// \file
/// The tables of the capture commands, from result.json.
#pragma once

#include "simgap/report/table.h"

namespace simgap {

/// \name capture
///@{
Table sightingTable(const Json& result);  ///< how well each target was seen
Table captureFigures(const Json& result);
///@}

/// \name calibrate-cameras
///@{
Table cameraFigures(const Json& result);
Table cameraParameters(const Json& result);
///@}

/// \name calibrate-joints
///@{
Table jointTable(const Json& result);
///@}

/// \name targets check
///@{
Table targetTable(const Json& result);  ///< what each target could be confused with; "!": noise could bridge it
Table crossTable(const Json& result);   ///< targets against each other
///@}

}  // namespace simgap
