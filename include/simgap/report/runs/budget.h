/// \file
/// Limits that a run has to keep: a regression test for a digital twin.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// One line of a budget (docs/formats.md, simgap/budget/1).
struct BudgetLimit {
  enum class Of { kValue, kParameter, kVerdict, kCause };
  Of of = Of::kValue;
  std::string subject;  ///< dotted name in result.json; pattern of parameters or causes; empty for the verdict
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double largest_sd_percent = std::numeric_limits<double>::infinity();  ///< of a parameter, relative to its value
  std::vector<std::string> allowed;                                     ///< verdicts
  std::string text;                                                     ///< the line in words
};

struct Budget {
  std::vector<BudgetLimit> limits;  ///< not empty
};

/// \throws ConfigError
Budget readBudget(const YamlNode& root);

/// result.json of `guard`: every limit, what was found, whether it holds. What is not in the result does not hold.
Json checkBudget(const Budget& budget, const ResultFiles& run);
bool holds(const Json& guard);

std::string guardText(const Json& guard);
std::string guardMarkdown(const Json& guard);
/// As continuous integration reads it: a test case per limit.
std::string guardJunit(const Json& guard);

}  // namespace simgap
