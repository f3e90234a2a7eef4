/// \file
/// Fits a spring, a shock cord or a tendon (000 section IV): force against one deflection,
///
///     F = stiffness x + offset + damping dx/dt,
///
/// of a cord with max(x, rest_length) instead of x, and no damping below: it only pulls. x is counted from anywhere, so
/// that the offset says where there is no force: x_0 = -offset / stiffness.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/fit_comparison.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

/// stiffness, offset, damping, rest_length
std::vector<std::string> springParameterNames();

struct SpringFitOptions {
  bool cord = false;  ///< it has a rest length
  std::map<std::string, double> fixed;
  std::map<std::string, Bounds> bounds;
};

struct SpringFit {
  bool cord = false;
  std::vector<double> theta;  ///< shape (3), of a cord (4): springParameterNames()
  Uncertainty uncertainty;
  double mse = 0.0;  ///< [N^2]
  std::size_t n = 0, parameters = 0, starts = 0, distinct_minima = 0;

  /// \param deflection [m], rate [m/s]  \returns [N]
  double force(double deflection, double rate) const;
};

/// \param log  of a spring. \param rows  shape (log rows): which to use; all that count when empty.
/// \throws DataError: too few rows, a constant channel, a force that falls where the deflection grows.
SpringFit fitSpring(const PreparedLog& log, const SpringFitOptions& options, const std::vector<bool>& rows = {});

double meanSquaredError(const SpringFit& fit, const PreparedLog& log, const std::vector<bool>& rows);

/// The deflection without force and its standard deviation (NaN when unknown): the rest length of a cord, else x_0.
struct Unloaded {
  double deflection, sd;
};
Unloaded unloadedDeflection(const SpringFit& fit);

using SpringCandidate = FitCandidate<SpringFit>;
/// A spring in both directions and a cord that only pulls (kCord), fitted to the same rows and judged on others: the
/// cord is best where it errs less there and some rows are slack.
using SpringComparison = FitComparison<SpringFit>;

/// \param holdout  kept from the fits; without one a fifth of five or more blocks judges, and the final fit has all
///        rows. \param block_s  length of the blocks [s]; empty: as blockSeconds
/// \throws DataError as fitSpring and fittedRows.
SpringComparison compareSprings(const PreparedLog& log, const SpringFitOptions& options, const Holdout& holdout,
                                const std::optional<double>& block_s);

}  // namespace simgap
