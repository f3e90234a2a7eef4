#include "simgap/fit/actuators/drive_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drive_parameters.h"
#include "drive_response.h"
#include "simgap/core/error.h"
#include "simgap/measure/logs/channel_checks.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Residuals of simulated against measured channels: per session the velocities, then the currents.
class ResponseProblem {
 public:
  ResponseProblem(const MotorLog& log, const DriveFitOptions& options, const std::vector<bool>& held)
      : log_(log),
        options_(options),
        held_(held),
        velocity_(!log.velocity.empty()),
        current_(!log.current.empty() && !log.voltage.empty()) {
    sessions_ = splitRows(log.session, log.rows());
    const std::size_t channels = (velocity_ ? 1 : 0) + (current_ ? 1 : 0);
    for (const Block& rows : sessions_) chunks_.push_back({rows.begin * channels, rows.end * channels});
  }

  double velocityScale = 1.0, currentScale = 1.0;  ///< standard deviation of each channel's residual

  LeastSquaresProblem problem() const {
    LeastSquaresProblem problem;
    problem.parameters = driveParameters(options_);
    if (options_.tie_constants) problem.parameters[kKt].fixed = true;
    problem.chunks = chunks_;
    problem.evaluate = [this](std::span<const double> theta, const Block& chunk, Eigen::Ref<VectorXd> residual,
                              Eigen::Ref<MatrixXd>* jacobian) {
      evaluate(theta, chunk, residual);
      if (jacobian == nullptr) return;
      std::vector<ParameterSpec> parameters = driveParameters(options_);
      if (options_.tie_constants) parameters[kKt].fixed = true;
      differentiateNumerically(
          parameters, theta, [&](std::span<const double> moved, Eigen::Ref<VectorXd> r) { evaluate(moved, chunk, r); },
          *jacobian);
    };
    return problem;
  }

  /// Session and channel of every residual, so that correlations do not reach over them.
  std::vector<int> labels() const {
    std::vector<int> all;
    for (std::size_t s = 0; s < sessions_.size(); ++s) {
      if (velocity_) all.insert(all.end(), sessions_[s].size(), static_cast<int>(2 * s));
      if (current_) all.insert(all.end(), sessions_[s].size(), static_cast<int>(2 * s + 1));
    }
    return all;
  }

  void evaluate(std::span<const double> theta, const Block& chunk, Eigen::Ref<VectorXd> residual) const {
    const auto session =
        static_cast<std::size_t>(std::ranges::lower_bound(chunks_, chunk.begin, {}, &Block::begin) - chunks_.begin());
    const Block& rows = sessions_[session];
    std::vector<double> all(theta.begin(), theta.end());
    if (options_.tie_constants) all[kKt] = all[kKe];
    std::vector<double> current(rows.size()), velocity(rows.size());
    simulateSession(log_, rows, motorOf(all), gearboxOf(all, options_.ratio), current, velocity);
    Index at = 0;
    const auto put = [&](const std::vector<double>& simulated, const std::vector<double>& measured, double scale) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const bool out = !held_.empty() && held_[rows.begin + i];
        residual[at++] = out ? 0.0 : (simulated[i] - measured[rows.begin + i]) / scale;
      }
    };
    if (velocity_) put(velocity, log_.velocity, velocityScale);
    if (current_) put(current, log_.current, currentScale);
  }

  bool hasVelocity() const { return velocity_; }
  bool hasCurrent() const { return current_; }

 private:
  const MotorLog& log_;
  const DriveFitOptions& options_;
  const std::vector<bool>& held_;
  bool velocity_, current_;
  std::vector<Block> sessions_, chunks_;
};

double rms(const std::vector<double>& simulated, const std::vector<double>& measured, const std::vector<bool>& held,
           bool of_held) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!held.empty() && held[i] != of_held) continue;
    sum += (simulated[i] - measured[i]) * (simulated[i] - measured[i]);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

double spread(const std::vector<double>& values) {
  const Eigen::Map<const VectorXd> v(values.data(), static_cast<Index>(values.size()));
  return std::sqrt((v.array() - v.mean()).square().mean());
}

void checkMotorLog(const MotorLog& log) {
  const ChannelCheck channels[] = {{"voltage_V", log.voltage, 2e3},
                                   {"current_A", log.current, 2e3},
                                   {"velocity_rad_s", log.velocity, 2e4},
                                   {"load_torque_Nm", log.load, 1e6}};
  (void)checkChannels(log.file, channels);
}

/// Fixes what a log without some channel cannot say anything about.
/// \returns names of the parameters that cannot be found: they get a placeholder that nothing depends on.
std::vector<std::string> settleMissing(const MotorLog& log, DriveFitOptions& options,
                                       std::vector<std::string>& warnings) {
  std::vector<std::string> missing;
  const auto fail = [&](const std::string& sentence) { throw DataError(log.file + ": " + sentence); };
  const bool voltage = varies(log.voltage), current = varies(log.current), velocity = varies(log.velocity);
  if (!voltage && !current) fail("found neither a voltage nor a current that varies, expected one: record steps");
  if (!velocity && !(voltage && current)) {
    fail("found no velocity that varies, expected it, or voltage and current from which it follows");
  }
  if (!log.voltage.empty() && !voltage) fail("voltage_V is constant throughout: record steps of voltage");
  if (!log.velocity.empty() && !velocity) fail("velocity_rad_s is constant throughout: record steps with motion");
  if (!log.current.empty() && !current) fail("current_A is constant throughout: nothing can be found from it");
  if (options.fit_motor && !voltage) {
    warnings.emplace_back("no voltage in the log: R, L and K_E cannot be found; record voltage_V");
    for (const char* name : {"R", "L", "K_E"}) {
      if (!options.fixed.contains(name)) missing.emplace_back(name);
      options.fixed.try_emplace(name, 1.0);
    }
  }
  if (options.fit_motor && !varies(log.load) && !options.fixed.contains("K_T")) {
    if (voltage) {
      options.tie_constants = true;
      warnings.emplace_back(
          "no load torque in the log: K_T is taken as K_E (an ideal motor's, in SI units); record "
          "load_torque_Nm, or --fix K_T=…");
    } else if (!options.fixed.contains("J_M")) {
      fail(
          "neither a load torque nor a voltage in the log: only ratios of K_T, J_M, mu_M and tau_CM act on it, "
          "expected "
          "one of them to be known (--fix K_T=…)");
    }
  }
  if (options.fit_motor && voltage && !current && !options.fixed.contains("R")) {
    warnings.emplace_back(
        "no current in the log: R and the torques can be found only in proportion; record current_A, "
        "or --fix R=…");
  }
  if (options.fit_gearbox && !varies(log.load)) {
    fail(
        "the load torque is missing or constant: efficiency and gear friction cannot be told apart; record several "
        "loads in both directions");
  }
  if (options.fit_gearbox && log.current.empty())
    fail("found no current_A, expected it: it carries the motor's torque");
  return missing;
}

/// Rough fits from the regression, and from mechanical parameters that are off by a factor; the best first.
std::vector<LeastSquaresResult> fitFromSeveralStarts(const LeastSquaresProblem& problem, std::vector<double> theta) {
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const ParameterSpec& p = problem.parameters[i];
    if (!p.fixed) theta[i] = std::clamp(std::max(theta[i], 1e-9), p.lower, p.upper);
  }
  LeastSquaresOptions rough;
  rough.max_iterations = 40;
  rough.function_tolerance = 1e-8;
  std::vector<LeastSquaresResult> found;
  for (const double factor : {1.0, 0.3, 3.0}) {
    std::vector<double> start = theta;
    for (const std::size_t i : {kJm, kMuM, kTauM, kMuG, kTauG, kJg}) {
      start[i] *= problem.parameters[i].fixed ? 1.0 : factor;
    }
    found.push_back(minimise(problem, start, rough));
  }
  std::ranges::stable_sort(found, {}, &LeastSquaresResult::cost);
  return found;
}

/// What is tied to another parameter takes its estimate over; what is missing has none.
void settleEstimates(Uncertainty& uncertainty, const DriveFitOptions& options,
                     const std::vector<std::string>& missing) {
  if (options.tie_constants) {
    Estimate& torque = uncertainty.estimates[kKt];
    const Estimate& emf = uncertainty.estimates[kKe];
    torque.value = emf.value, torque.sd = emf.sd, torque.lower95 = emf.lower95, torque.upper95 = emf.upper95;
  }
  for (Estimate& e : uncertainty.estimates) {
    if (std::ranges::find(missing, e.name) == missing.end()) continue;
    e.value = e.sd = e.lower95 = e.upper95 = std::nan("");
    e.fixed = e.identifiable = false;
  }
}

}  // namespace

DriveFit fitDrive(const MotorLog& log, const DriveFitOptions& given, const std::vector<bool>& held) {
  checkMotorLog(log);
  DriveFitOptions options = given;
  DriveFit fit;
  const std::vector<std::string> missing = settleMissing(log, options, fit.warnings);
  fit.rows = log.rows();
  fit.first_guess = driveFirstGuess(log, options);
  ResponseProblem response(log, options, held);
  const LeastSquaresProblem problem = response.problem();
  const std::size_t free = problem.freeParameters().size();
  if (log.rows() <= free) {
    throw DataError(fmt::format("{}: found {} rows for {} parameters, expected many more", log.file, log.rows(), free));
  }
  const auto measure = [&](std::span<const double> at) {
    std::vector<double> all(at.begin(), at.end());
    if (options.tie_constants) all[kKt] = all[kKe];
    return simulateDrive(log, motorOf(all), gearboxOf(all, options.ratio));
  };
  // The channels' weights follow the fit.
  response.velocityScale = response.hasVelocity() ? spread(log.velocity) : 1.0;
  response.currentScale = response.hasCurrent() ? spread(log.current) : 1.0;
  const std::vector<LeastSquaresResult> found = fitFromSeveralStarts(problem, fit.first_guess);
  fit.starts = found.size();
  fit.distinct_minima = 1;
  for (std::size_t k = 1; k < found.size(); ++k) {
    if (found[k].cost > 1.001 * found[k - 1].cost) ++fit.distinct_minima;
  }
  LeastSquaresResult best = found.front();
  for (int round = 0; round < 2; ++round) {
    const DriveResponse r = measure(best.theta);
    if (response.hasVelocity())
      response.velocityScale = std::max(rms(r.velocity, log.velocity, held, false), 1e-9 * response.velocityScale);
    if (response.hasCurrent())
      response.currentScale = std::max(rms(r.current, log.current, held, false), 1e-9 * response.currentScale);
    best = minimise(problem, best.theta);
  }
  if (!best.converged) fit.warnings.push_back("the fit stopped early: " + best.message);
  fit.theta = best.theta;
  if (options.tie_constants) fit.theta[kKt] = fit.theta[kKe];
  fit.uncertainty = estimateUncertainty(problem, best.theta, response.labels());
  settleEstimates(fit.uncertainty, options, missing);
  const DriveResponse r = measure(fit.theta);
  const auto channel = [&](const char* name, const char* unit, const std::vector<double>& simulated,
                           const std::vector<double>& measured) {
    DriveChannel c{name, unit, rms(simulated, measured, held, false), std::nullopt, spread(measured)};
    if (!held.empty()) c.rms_heldout = rms(simulated, measured, held, true);
    fit.channels.push_back(c);
  };
  if (response.hasVelocity()) channel("velocity", "rad_s", r.velocity, log.velocity);
  if (response.hasCurrent()) channel("current", "A", r.current, log.current);
  return fit;
}

}  // namespace simgap
