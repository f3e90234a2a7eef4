/// \file
/// A log of a spring, a shock cord or a tendon: its force against one deflection (docs/formats.md, "Logs").
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// Force [N] against deflection [m], or torque [N m] against angle [rad]; tension counts positive. Shape (rows) each.
struct SpringLog {
  std::string file;
  std::vector<double> deflection;
  std::vector<double> force;
  std::vector<double> time;  ///< [s]; rows in their order, counted from 0, when the log has none
  std::vector<int> session;
  std::vector<std::string> session_names;
  bool angular = false;     ///< rad and N m
  bool own_length = false;  ///< the deflection is the spring's length, not counted from anywhere: `length_m`
  bool has_time = false;

  std::size_t rows() const { return force.size(); }
  const char* deflectionColumn() const { return angular ? "deflection_rad" : own_length ? "length_m" : "deflection_m"; }
  const char* deflectionUnit() const { return angular ? "rad" : "m"; }
  const char* forceName() const { return angular ? "torque" : "force"; }
  const char* forceUnit() const { return angular ? "Nm" : "N"; }
};

/// Reads `deflection_m` or `length_m` with `force_N`, or `deflection_rad` with `torque_Nm`, and what there is of
/// `time_s` and `session`. \throws DataError: neither or both deflections, no force, time that does not rise within a
/// session, and all that
///         CsvTable refuses.
SpringLog readSpringLog(CsvTable table);
/// The same of a log that a spring is to be fitted to. \throws DataError for a force that falls where the deflection
/// grows, too.
SpringLog readSignedSpringLog(const CsvTable& table);

/// Rows with the largest or smallest value of a channel, where it stays on that for at least four rows while the other
/// channel moves on, twice or more: a sensor at its limit. At rest both stand still, and a coarse channel repeats its
/// values then.
/// \param values, other  shape (n)
std::vector<std::size_t> findClipped(std::span<const double> values, std::span<const double> other,
                                     std::span<const int> session);

}  // namespace simgap
