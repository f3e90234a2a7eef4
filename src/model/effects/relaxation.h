/// \file
/// Relaxation, and the times of it that a log can show: of some time steps and more, and short enough to see it die
/// away.
#pragma once

#include <algorithm>
#include <cmath>

#include "simgap/measure/logs/actuator_rows.h"

namespace simgap::actuator_effects {

/// Of the longest session. What is slower is a drift in it, or an encoder that slips once: a creep of two thirds of a
/// session, known to twice its size, stood for that.
inline constexpr double kLongestRelaxation = 1.0 / 3.0;
inline constexpr double kShortestRelaxation = 3.0;  // time steps: faster is damping, or a sensor's or valve's lag

inline double longestSession(const ActuatorRows& rows) {
  double longest = 0.0;
  for (Eigen::Index i = 1, begin = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] != rows.session[k - 1]) begin = i;
    longest = std::max(longest, rows.time[i] - rows.time[begin]);
  }
  return longest;
}

/// What a spring and a damper in series hold of the stretches of `x`, shape (rows): dy/dt = dx/dt - y / tau, solved
/// exactly for an x that changes linearly between rows. Every session begins relaxed. \param tau  > 0 [s]
inline Eigen::ArrayXd maxwellBranch(const ActuatorRows& rows, double tau, const Eigen::ArrayXd& x) {
  Eigen::ArrayXd y = Eigen::ArrayXd::Zero(rows.rows());
  for (Eigen::Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] != rows.session[k - 1]) continue;
    const double dt = rows.time[i] - rows.time[i - 1], stays = std::exp(-dt / tau);
    y[i] = stays * y[i - 1] + tau / dt * (1.0 - stays) * (x[i] - x[i - 1]);
  }
  return y;
}

/// \name Rubbers creep on many time scales: over `decades` > 0 five branches about tau share it alike, else one has it.
///@{
inline int branchCount(double decades) { return decades > 0.0 ? 5 : 1; }
inline double branchTime(double tau, double decades, int branch) {
  const int branches = branchCount(decades);
  const double place = branches > 1 ? static_cast<double>(branch) / (branches - 1) - 0.5 : 0.0;
  return tau * std::pow(10.0, decades * place);
}
///@}

/// Where a search may begin [s]. \param part  0: fast, 1: slow
inline double relaxationTime(const ActuatorRows& rows, double part) {
  const double low = 3.0 * kShortestRelaxation * rows.step,
               high = std::max(kLongestRelaxation * longestSession(rows), 2.0 * low);
  return low * std::pow(high / low, part);
}

inline bool showsRelaxation(const ActuatorRows& rows, double tau) {
  return tau > kShortestRelaxation * rows.step && tau < kLongestRelaxation * longestSession(rows);
}

}  // namespace simgap::actuator_effects
