/// \file
/// The result of `predict` as JSON (docs/formats.md), CSV and lines for the terminal.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/actuators/prediction.h"

namespace simgap {

/// \param kind  of the model: "friction"
Json toJson(const Prediction& prediction, const std::string& kind);
std::string predictionCsv(const Prediction& prediction);
/// \param file  where the CSV went
std::string terminalTable(const Prediction& prediction, const std::string& file);

}  // namespace simgap
