/// \file
/// Fits the DC motor (000 eq. 8-9) and the gearbox (000 eq. 10-11) to logs. A regression of the equations gives the
/// first guess, as 000 did; then the simulated response to the logged voltage (or, without it, current) and load is
/// fitted to what was measured of current and velocity, so that noise in derivatives does not bias the result and
/// neither steps nor loads need be synchronised.
///
///     L di/dt = V - R i - K_E w           J dw/dt = N eta K_T i - b w - c sign(w) - T
///     J = N eta J_M + J_G / N,  b = N eta mu_M + mu_G / N,  c = N eta tau_CM + tau_CG
///
/// Channels are seldom sampled at one instant: how late voltage and current are against the velocity is fitted, too.
/// Taken as 0, half a sample moves inertia and inductance by many times their standard deviation.
///
/// A load that is not in the log would enter the simulated velocity, through the back-EMF the current, and with it R, L
/// and the delays. Where velocity or current are missed, the winding alone is fitted, its velocity the measured one.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/model/arm/arm.h"
#include "simgap/optimize/least_squares.h"
#include "simgap/optimize/uncertainty.h"
#include "simgap/simulate/drive_response.h"

namespace simgap {

struct DriveFitOptions {
  bool fit_motor = true;  ///< its parameters are free
  bool fit_gearbox = false;
  Motor motor;  ///< known values when it is not fitted
  /// Of R, L, K_E, K_T, J_M, mu_M and tau_CM when the motor is not fitted; empty when it is not known.
  Eigen::MatrixXd motor_covariance;
  double ratio = 1.0;  ///< N
  std::map<std::string, double> fixed;
  std::map<std::string, Bounds> bounds;
  bool tie_constants = false;  ///< K_T = K_E (SI units, ideal DC motor)
  double block_seconds = 20.0;
  std::optional<DriveExtent> extent;  ///< of a winding alone, what moves the rotor is not found; none: as the log asks
};

/// One measured channel that the simulation is compared with.
struct DriveChannel {
  std::string name;  ///< "velocity"
  std::string unit;
  double rms = 0.0;  ///< of the residual, on all rows
  std::optional<double> rms_heldout;
  double spread = 0.0;  ///< standard deviation of the measurement
};

/// A delay that was fitted.
struct FittedDelay {
  std::string channel;  ///< "voltage_V"
  std::string against;  ///< "velocity_rad_s"
  double seconds = 0.0, sd = 0.0;
  double rows = 0.0;  ///< the same in steps of the log
};

/// How many of a drive's parameters are the motor's, and how many are its and the gearbox's, before the delays.
inline constexpr std::size_t kMotorParameters = 7, kDriveParameters = 11;

struct DriveFit {
  std::vector<double> first_guess;  ///< shape (P)
  /// Shape (P): R, L, K_E, K_T, J_M, mu_M, tau_CM, eta, tau_CG, mu_G, J_G, and the delays of voltage and current [s].
  std::vector<double> theta;
  Uncertainty uncertainty;
  std::vector<DriveChannel> channels;
  DriveDelays delays;
  DriveExtent extent = DriveExtent::kWhole;  ///< the winding alone where the log does not hold what acts on the motor
  std::vector<FittedDelay> fitted_delays;
  std::size_t rows = 0;  ///< that the fit saw
  std::size_t starts = 0, distinct_minima = 0;
  std::vector<std::string> warnings;  ///< what could not be found, and why; its estimates are NaN
};

/// \param rows  shape (rows): that are fitted; empty for all.
/// \throws DataError: channels that make the whole fit impossible, with what to record.
DriveFit fitDrive(const MotorLog& log, const DriveFitOptions& options, const std::vector<bool>& rows = {});

/// Names of what a log could not tell.
std::vector<std::string> notFound(const Uncertainty& uncertainty);

Motor motorOf(std::span<const double> theta);
Gearbox gearboxOf(std::span<const double> theta, double ratio);

}  // namespace simgap
