/// \file
/// Options that the fit-* commands share.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

struct FitOptions {
  std::vector<std::string> fix;     ///< "k_a=1.3"
  std::vector<std::string> bounds;  ///< "k_v=0:5"
  std::vector<std::string> sessions;
  std::string holdout;                ///< "0.2" or "session=5,6"
  std::optional<double> block_s;      ///< default: kBlockSeconds, or a tenth of the log when that is shorter
  std::vector<std::string> validate;  ///< further logs
  void add(CLI::App& app);

  static constexpr double kBlockSeconds = 20.0;
  /// Length of the blocks for a log of that duration [s].
  double blockSeconds(double duration) const {
    return block_s.value_or(duration > 0.0 ? std::min(kBlockSeconds, duration / 10.0) : kBlockSeconds);
  }
  std::map<std::string, double> fixed() const;            ///< \throws ConfigError
  std::map<std::string, Bounds> parameterBounds() const;  ///< \throws ConfigError
};

/// What `--holdout` names, of a log's table: rows by a column's values, or a fraction of the blocks.
struct Holdout {
  std::optional<double> fraction;
  std::vector<bool> rows;  ///< shape (rows): named by values
  std::string words;       ///< for reports

  bool any() const { return fraction.has_value() || !rows.empty(); }
};

/// \throws ConfigError for a text that is neither, DataError for values that no row has.
Holdout readHoldout(const std::string& text, const CsvTable& table);

/// The rows that are held out, shape (rows of `blocks`). \param row  row of the log of each of them.
std::vector<bool> heldOutRows(const Holdout& holdout, std::span<const Block> blocks, std::span<const std::size_t> row);

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

/// \throws ConfigError when `options` names a parameter none of the models has.
void requireKnownParameters(const FitOptions& options, const std::vector<ParameterSpec>& known);

}  // namespace simgap
