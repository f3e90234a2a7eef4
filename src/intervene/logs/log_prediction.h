/// \file
/// What a candidate of a diagnosis predicts for a log after a change of the bench, and how surely.
#pragma once

#include "simgap/intervene/logs/log_intervention.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

/// A candidate's prediction, shape (rows) of the rows that mean something.
struct PredictedRows {
  Eigen::ArrayXd values;   ///< [effort_unit]
  Eigen::MatrixXd spread;  ///< s A, shape (rows, K): what one standard deviation of each direction does
};

/// The rows of a log as the changed bench makes them.
struct ChangedLog {
  PreparedLog log;
  LogSetting setting;
  std::vector<Eigen::Index> rows;  ///< that mean something
};

/// \param recorded  the table is a log from afterwards, not a reference. \throws as judgeChange.
ChangedLog changedLog(const LogEvidence& evidence, const LogChanges& change, const CsvTable& table, bool recorded);

/// \param moved  the same log with one uncertain number of the change a standard deviation forward, and back.
PredictedRows predictRows(const LogEvidence::Candidate& candidate, const ChangedLog& changed,
                          const std::vector<std::pair<ChangedLog, ChangedLog>>& moved);

/// e^T S^-1 e with S = tau 1 + A A^T, the least of |e - A x|^2 / tau + |x|^2 over x, in its two parts: a few parameters
/// that are far off cost little beside many rows, and have to be looked at by themselves.
struct Distance {
  double beside = 0.0;      ///< what no x explains
  double along = 0.0;       ///< what parameters within their uncertainty would have to explain
  int directions = 0;       ///< degrees of freedom of `along`
  Eigen::VectorXd left;     ///< e - A x, shape (rows)
  double log_volume = 0.0;  ///< ln|1 + A^T A / tau|

  double value() const { return beside + along; }
};
Distance distanceOf(const Eigen::VectorXd& e, const Eigen::MatrixXd& a, double tau);

}  // namespace simgap
