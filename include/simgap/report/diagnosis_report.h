/// \file
/// The answer of `diagnose` as JSON (FORMATS), CSV, one screen for the terminal and a page.
#pragma once

#include <string>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/report/page.h"

namespace simgap {

Json toJson(const Diagnosis& diagnosis);
std::string hypothesesCsv(const Diagnosis& diagnosis);
std::string evidenceCsv(const Diagnosis& diagnosis);
/// Hidden effects by row, answers by column.
std::string confusionCsv(const SelfTest& test);
std::string terminalTable(const Diagnosis& diagnosis);
Page makePage(const Diagnosis& diagnosis);

}  // namespace simgap
