/// \file
/// Runs of one command, of several days, units or robots, held against each other: errors, parameters, causes.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/optimize/pooling.h"

namespace simgap {

struct RunParameter {
  std::string name, unit;
  GroupEstimate estimate;
};

struct RunCause {
  std::string name;       ///< effect, with its target or channel: "bend-friction", "payload:forearm"
  double gain = 0.0;      ///< on data it never used [%]; NaN: unknown
  std::string magnitude;  ///< its parameters in words
};

/// What a finished run found that another can be held against.
struct RunFigures {
  std::string name;               ///< its directory, as it was given
  std::string format;             ///< of its result: "simgap/fit-friction/1"
  std::string start;              ///< UTC
  std::string subject;            ///< law or model; may be empty
  std::string verdict;            ///< of a diagnosis; otherwise empty
  std::vector<std::string> data;  ///< SHA-256 of the tables it read
  std::vector<std::pair<std::string, double>> errors;
  std::vector<RunParameter> parameters;       ///< those with a standard deviation, neither fixed nor at a bound
  std::vector<std::string> without_interval;  ///< fitted, too, but at a bound or not determined
  std::vector<RunCause> causes;
};

/// \throws ConfigError: no directory of a run with a result; DataError: a result that cannot be read so.
RunFigures readRun(const std::filesystem::path& directory);

/// result.json of `compare` (docs/formats.md). Parameters that at least two runs estimate are pooled; what differs at 5
/// % after Holm's adjustment over all of them is tested for a step and a drift in the order given. \throws DataError:
/// runs of different commands. \param runs  at least two
Json compareRuns(const std::vector<RunFigures>& runs);

/// The answer in one sentence: what differs, by how much and since when.
std::string comparisonAnswer(const Json& result);
std::string comparisonText(const Json& result);
/// One row per parameter and run.
std::string comparisonCsv(const Json& result);

}  // namespace simgap
