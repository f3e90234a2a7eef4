/// \file
/// The answer of `diagnose` as JSON (FORMATS), CSV and one screen for the terminal.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

Json toJson(const Diagnosis& diagnosis);
std::string hypothesesCsv(const Diagnosis& diagnosis);
std::string evidenceCsv(const Diagnosis& diagnosis);
/// Hidden effects by row, answers by column.
std::string confusionCsv(const SelfTest& test);
std::string terminalTable(const Diagnosis& diagnosis);

}  // namespace simgap
