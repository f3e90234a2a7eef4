/// \file
/// A change of the bench that was made on purpose tells causes apart that fit the same log: every candidate of a
/// diagnosis predicts the log after it with nothing refitted,
///
///     e = (predicted - measured) / s,   e ~ N(0, S),   S = tau 1 + A A^T,   A = (J L, g_1, g_2 …) / s
///
/// s^2: the candidate's mean squared error on blocks that it had not seen; tau [rows]: how far the errors of neighbours
/// are alike, so that n rows count as n / tau; J: derivatives by the parameters, L L^T their covariance; g_k: what one
/// standard deviation of an uncertain number of the change does. Its distance D = e^T S^-1 e is the least of
/// |e - A x|^2 / tau + |x|^2 over x. How well s is known (nu degrees of freedom) makes of it Student's density,
///
///     ln p = -n ln s / tau - ln|1 + A^T A / tau| / 2 - (nu + n / tau) / 2 ln(1 + D / nu) + const(nu)
///
/// and F-distributed ratios of two parts of D, along A and beside it: the smaller p of them, twice.
#pragma once

#include <string>
#include <vector>

#include "simgap/diagnose/logs/log_diagnosis.h"
#include "simgap/intervene/intervention.h"
#include "simgap/intervene/logs/log_change.h"
#include "simgap/measure/logs/log_table.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// What a diagnosis of a log knew.
struct LogEvidence {
  struct Candidate {
    LogCandidate known;
    FittedModel model;
  };
  std::vector<Candidate> candidates;  ///< the named one first
  Bench bench;                        ///< before the change
  double correlation_s = 0.0;         ///< [s] of the named model's errors
  std::string reference;              ///< CSV: a log that shows what motion and load to expect
  std::string reference_file;         ///< its name, for errors
};

/// What one candidate said of the log after the change.
struct LogPrediction {
  double rms = 0.0;              ///< [effort_unit]
  double rms_before = 0.0;       ///< the same on blocks of the log before that it had not seen
  double distance = 0.0;         ///< D
  double freedom = 0.0;          ///< n / tau, which D is to be compared with
  double p = 0.0;                ///< of a distance as large, were the candidate right
  double log_odds_before = 0.0;  ///< against the named candidate, from the log before
  double log_odds = 0.0;         ///< the same from the log after the change alone
  Eigen::ArrayXd predicted;      ///< shape (rows) [effort_unit]
};

struct LogIntervention {
  InterventionVerdict verdict = InterventionVerdict::kCannotTell;  ///< on the named candidate
  std::string sentence;
  std::vector<LogPrediction> predictions;  ///< shape (candidates)
  Eigen::ArrayXd time, measured;           ///< shape (rows): those that mean something [s], [effort_unit]
  std::size_t rows = 0;                    ///< that were compared
  std::size_t left_out = 0;                ///< rows, 1 % at most, that no candidate comes near: outliers
  std::string unit;                        ///< of the effort: "A"
};

/// A log after a change judges the candidates. \param change  empty: only motion and load are others.
/// \throws ConfigError: a bench or cause that cannot be changed so. DataError: as prepareLog; another effort's unit.
LogIntervention judgeChange(const LogEvidence& evidence, const LogChanges& change, const CsvTable& after);

/// The reference log with its channels as the change makes them. \throws DataError: as CsvTable
CsvTable profileOf(const LogEvidence& evidence, const LogChanges& change);
/// The same as the file of a motion to record: without the effort, which belongs to the log that it was made from.
std::string nextLogCsv(const LogEvidence& evidence, const LogChanges& change);

/// What a change would tell, were the reference log's motion to be recorded after it.
struct ForeseenLogChange {
  /// shape (candidates, candidates): expected log odds of the row's candidate over the column's, were the row's right
  std::vector<std::vector<double>> log_odds;
  double smallest = 0.0;              ///< of the named candidate against any that contradicts it, either of them right
  std::vector<double> largest_shift;  ///< shape (candidates) [effort_unit]: furthest from the named one's prediction
  std::vector<double> in_noise;       ///< the same in standard deviations of a row's error
  std::vector<std::string> where;     ///< shape (candidates): time, speed and load of it
  Eigen::ArrayXd time;                ///< shape (rows) [s]
  std::vector<Eigen::ArrayXd> predicted;  ///< shape (candidates) of (rows) [effort_unit]
  std::string unit;
};

/// \throws as judgeChange
ForeseenLogChange foreseeChange(const LogEvidence& evidence, const LogChanges& change);

}  // namespace simgap
