/// \file
/// Friction laws on the rows they were fitted to: where they err, and their curves where the rows are (003 figures 10,
/// 12-14 and 16).
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "simgap/fit/actuators/friction_comparison.h"

namespace simgap {

/// Laws fitted to the rows of a log.
struct FittedRows {
  const FrictionData& data;
  const FrictionFitOptions& options;
  const FrictionComparison& laws;

  const FrictionFit& best() const { return laws.fits[laws.best]; }
  /// Load of every row as the best law sees it, shape (rows).
  Eigen::ArrayXd load() const;
  /// What is predicted: the effort or the load, shape (rows).
  const Eigen::ArrayXd& measured() const { return options.predict_load ? data.load : data.effort; }
};

/// Rows and errors of every law over load and velocity.
struct ErrorMap {
  std::vector<double> velocity, load;      ///< centres of the cells, shape (cells per axis)
  std::vector<double> count;               ///< rows, shape (cells per axis squared), velocity runs fastest
  std::vector<std::vector<double>> error;  ///< shape (fits, cells): mean absolute error; NaN without rows
};
ErrorMap errorMap(const FittedRows& rows);

/// A row that the plot over time shows.
struct TimeSample {
  std::size_t index;
  double measured;
  std::vector<double> predicted;  ///< shape (fits)
};
/// At most some 1,500 rows in order: a stretch without gaps around the middle of the log.
std::vector<TimeSample> timeSamples(const FittedRows& rows);

/// Quantile bands of the load, at most four: lower and upper end.
std::vector<std::pair<double, double>> loadBands(const Eigen::ArrayXd& load);

/// Velocities at which a curve is drawn, denser where it bends. Slower than nearly all rows a law is a guess: a peak at
/// rest that no row has seen would only flatten the picture of what they have.
std::vector<double> curveVelocities(const FrictionData& data);

}  // namespace simgap
