/// \file
/// What a drive's log says is missing in a friction model: every cause of the catalogue refits the whole model, is
/// judged on blocks it has not seen, and what is accepted is measured once more on blocks that had no part in the
/// choice.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

struct LogDiagnosisOptions : DiagnosisOptions {
  int max_causes = 4;
  double least_gain = 0.015;            ///< of the mean squared error that a cause has to save
  double holdout = 0.25;                ///< fraction of the blocks that only measure the gain
  std::vector<bool> heldout_rows = {};  ///< shape (rows): instead of `holdout`
  int self_tests = 0;                   ///< injections of every effect, and of none, into this design
};

/// A model fitted to all rows, with what is known of its parameters.
struct LogFit {
  std::vector<const ActuatorEffect*> effects;
  std::vector<double> theta;
  std::vector<Estimate> parameters;
  std::vector<Extension> extensions;
  double t = 0.0;  ///< 97.5 % quantile of Student's t for their deviations: of as many blocks as there were
};

/// What the log says of a candidate besides its values.
struct LogPosterior {
  std::vector<std::string> names;  ///< shape (P): of theta, as ActuatorRegression::parameters()
  Eigen::MatrixXd covariance;      ///< shape (P, P) of theta
  double variance = 0.0;           ///< mean squared error on blocks that a refit had not seen
  double freedom = 1.0;            ///< degrees of freedom that `variance` is known with
  double log_odds = 0.0;           ///< of the unseen blocks, against the named candidate
};

struct LogCandidate {
  std::string causes;  ///< "bend-friction, current-bias"; "none"
  std::string role;    ///< "named", "instead" (another cause in the place of a named one), "without", "refused"
  LogPosterior posterior;
};

/// As the diagnosis leaves it.
struct FittedLogCandidate {
  LogCandidate candidate;
  LogFit fit;
};

struct LogDiagnosis {
  Diagnosis diagnosis;
  LogFit baseline, extended;
  Eigen::ArrayXd predicted_before, predicted_after;  ///< shape (rows)
  std::vector<FittedLogCandidate> candidates;        ///< the extended model first
  double correlation_s = 0.0;                        ///< [s] of its residuals
};

/// What can be known before any work. \throws ConfigError: an unknown effect; DataError: too few blocks to learn from.
void requireDiagnosable(const PreparedLog& log, const LogDiagnosisOptions& options);

/// \throws DataError when the log cannot be fitted at all, and as requireDiagnosable.
LogDiagnosis diagnoseLog(const ActuatorModel& subject, PreparedLog& log, const LogDiagnosisOptions& options,
                         const DiagnosisProgress& progress = {});

/// A model with its effects, fitted to another log.
struct LogRefit {
  LogFit fit;
  double mse = 0.0;          ///< of all rows that count
  double mse_heldout = 0.0;  ///< every fifth of the blocks predicted by a refit to the others
  std::size_t rows = 0;      ///< that count
  double effective_samples = 0.0;
  Eigen::ArrayXd predicted;  ///< shape (rows of the log)
};

/// Starts from the values of `subject`. \throws as requireDiagnosable.
LogRefit refitLog(const ActuatorModel& subject, const PreparedLog& log);

}  // namespace simgap
