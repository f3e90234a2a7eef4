/// \file
/// Options that the fit-* commands share, and the refit of a diagnosed model that all of them offer.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

struct FitOptions {
  std::vector<std::string> fix;     ///< "k_a=1.3"
  std::vector<std::string> bounds;  ///< "k_v=0:5"
  std::vector<std::string> sessions;
  std::string holdout;                ///< "0.2" or "session=5,6"
  std::optional<double> block_s;      ///< empty: as blockSeconds
  std::vector<std::string> validate;  ///< further logs
  void add(CLI::App& app);
  ParameterChoices parameters() const { return readParameterChoices(fix, bounds); }  ///< \throws ConfigError
};

/// The end of a fit command's definition: the options that all of them have, and what runs it.
template <typename Options, typename Run>
std::function<ExitCode()> defineFit(const std::shared_ptr<Options>& options, CLI::App& app,
                                    const std::vector<std::string>& argv, const Run& run) {
  options->fit.add(app);
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app, run] { return run(*options, argv, app); };
}

/// config.resolved.yaml: the options that were given.
std::string resolvedOptions(const CLI::App& app);

/// The end of a fit: its files in a new result directory, its tables on the terminal.
/// \param left_out  sentences about rows of the log that were left out. \param write  model and tables
void finishFit(Session& session, const CLI::App& app, FitSummary summary, const std::vector<std::string>& left_out,
               const std::function<void(const RunDirectory&)>& write);

/// `fit-* LOG --model FILE`: law and extensions of a diagnosed model, fitted together to a log.
struct RefitOptions {
  std::string command;  ///< "fit-friction"
  std::string model, log;
  LogFileOptions table;
  Bench bench = {};
};
/// \throws ConfigError: a model of another kind than the command fits; an option that only a law by name takes.
ExitCode runRefit(const RefitOptions& options, Session& session, const CLI::App& app);

}  // namespace simgap
