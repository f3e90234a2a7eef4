#include "simgap/fit/actuators/drive_fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "drive_parameters.h"
#include "drive_units.h"
#include "missing_channels.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Residuals of simulated against measured channels: row by row velocity and current, so that blocks of rows hold both;
/// on the rows that are fitted.
class ResponseProblem {
 public:
  ResponseProblem(const MotorLog& log, const DriveFitOptions& options, const std::vector<bool>& rows)
      : log_(log),
        options_(options),
        fitted_(rows),
        velocity_(!log.velocity.empty() && *options.extent == DriveExtent::kWhole),
        current_(!log.current.empty() && !log.voltage.empty()),
        step_(meanStep(log)),
        typical_(kCount, 0.0) {
    parameters_ = driveParameters(options, step_);
    if (options.tie_constants) tieConstants();
    for (const Block& session : splitRows(log.session, log.rows())) {
      std::size_t kept = 0;
      for (std::size_t i = session.begin; i < session.end; ++i) kept += counts(i) ? 1 : 0;
      if (kept == 0) continue;
      const std::size_t begin = chunks_.empty() ? 0 : chunks_.back().end;
      sessions_.push_back(session);
      chunks_.push_back({begin, begin + kept * channels()});
    }
  }

  double velocityScale = 1.0, currentScale = 1.0;  ///< standard deviation of each channel's residual

  /// \param theta  near which derivatives are taken. \param given_too  also by the motor's parameters that are given
  LeastSquaresProblem problem(std::span<const double> theta, bool given_too = false) {
    typical_ = typicalSizes(log_, theta, options_.ratio);
    LeastSquaresProblem problem;
    problem.parameters = parameters_;
    problem.chunks = chunks_;
    std::vector<ParameterSpec> moving = parameters_;
    for (std::size_t i = 0; given_too && i < kMotorParameters; ++i) moving[i].fixed = false;
    problem.evaluate = [this, moving](std::span<const double> at, const Block& chunk, Eigen::Ref<VectorXd> residual,
                                      Eigen::Ref<MatrixXd>* jacobian) {
      evaluate(at, chunk, residual);
      if (jacobian == nullptr) return;
      differentiateNumerically(
          moving, at, typical_,
          [&](std::span<const double> moved, Eigen::Ref<VectorXd> r) { evaluate(moved, chunk, r); }, *jacobian);
    };
    return problem;
  }

  /// Session of every residual, so that correlations do not reach over them.
  std::vector<int> labels() const {
    std::vector<int> all;
    for (std::size_t s = 0; s < chunks_.size(); ++s) all.insert(all.end(), chunks_[s].size(), static_cast<int>(s));
    return all;
  }

  DriveDelays delays(std::span<const double> theta) const { return delaysOf(log_, theta, step_); }
  double step() const { return step_; }
  bool hasVelocity() const { return velocity_; }
  bool hasCurrent() const { return current_; }
  std::size_t channels() const { return (velocity_ ? 1 : 0) + (current_ ? 1 : 0); }
  std::size_t rows() const { return chunks_.empty() ? 0 : chunks_.back().end / channels(); }

 private:
  /// One constant, within the bounds of both.
  void tieConstants() {
    ParameterSpec &emf = parameters_[kKe], &torque = parameters_[kKt];
    torque.fixed = true;
    emf.lower = std::max(emf.lower, torque.lower);
    emf.upper = std::min(emf.upper, torque.upper);
    if (emf.lower < emf.upper) return;
    throw ConfigError(
        "--bounds K_E and --bounds K_T have nothing in common, expected ranges of one constant: the log "
        "cannot tell them apart");
  }

  bool counts(std::size_t row) const { return fitted_.empty() || fitted_[row]; }

  void evaluate(std::span<const double> theta, const Block& chunk, Eigen::Ref<VectorXd> residual) const {
    const auto session =
        static_cast<std::size_t>(std::ranges::lower_bound(chunks_, chunk.begin, {}, &Block::begin) - chunks_.begin());
    const Block& rows = sessions_[session];
    std::vector<double> all(theta.begin(), theta.end());
    if (options_.tie_constants) all[kKt] = all[kKe];
    std::vector<double> current(rows.size()), velocity(rows.size());
    simulateSession(log_, rows, motorOf(all), gearboxOf(all, options_.ratio), delays(all), *options_.extent, current,
                    velocity);
    Index at = 0;
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      if (!counts(i)) continue;
      if (velocity_) residual[at++] = (velocity[i - rows.begin] - log_.velocity[i]) / velocityScale;
      if (current_) residual[at++] = (current[i - rows.begin] - log_.current[i]) / currentScale;
    }
  }

  const MotorLog& log_;
  const DriveFitOptions& options_;
  const std::vector<bool>& fitted_;
  bool velocity_, current_;
  double step_;
  std::vector<double> typical_;
  std::vector<ParameterSpec> parameters_;
  std::vector<Block> sessions_, chunks_;
};

double rms(const std::vector<double>& simulated, const std::vector<double>& measured, const std::vector<bool>& rows,
           bool of_fitted = true) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!rows.empty() && rows[i] != of_fitted) continue;
    sum += (simulated[i] - measured[i]) * (simulated[i] - measured[i]);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

void checkMotorLog(const MotorLog& log) {
  const ChannelCheck channels[] = {{"voltage_V", log.voltage, 2e3},
                                   {"current_A", log.current, 2e3},
                                   {"velocity_rad_s", log.velocity, 2e4},
                                   {"load_torque_Nm", log.load, 1e6}};
  (void)checkChannels(log.file, channels);
}

/// Rough fits from the regression, and from mechanical parameters that are off by a factor.
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
    if (factor != 1.0 && start == theta) continue;
    found.push_back(minimise(problem, start, rough));
  }
  return found;
}

/// From the best of several starts, with weights of the channels that follow the fit.
/// \param measure  what is simulated with theta
template <class Measure>
LeastSquaresResult fitWeighted(const MotorLog& log, const LeastSquaresProblem& problem, const Measure& measure,
                               const std::vector<bool>& rows, ResponseProblem& response, DriveFit& fit) {
  response.velocityScale = response.hasVelocity() ? standardDeviation(log.velocity) : 1.0;
  response.currentScale = response.hasCurrent() ? standardDeviation(log.current) : 1.0;
  constexpr double kSameRough = 1.001;  // costs of rough fits that differ by less are of one minimum
  std::vector<LeastSquaresResult> found = fitFromSeveralStarts(problem, fit.first_guess);
  fit.starts = found.size();
  fit.distinct_minima = rankMinima(found, kSameRough);
  LeastSquaresResult best = found.front();
  for (int round = 0; round < 2; ++round) {
    const DriveResponse r = measure(best.theta);
    if (response.hasVelocity())
      response.velocityScale = std::max(rms(r.velocity, log.velocity, rows), 1e-9 * response.velocityScale);
    if (response.hasCurrent())
      response.currentScale = std::max(rms(r.current, log.current, rows), 1e-9 * response.currentScale);
    best = minimise(problem, best.theta);
  }
  return best;
}

/// The delays that were fitted; a sentence about each that is clearly none.
void takeDelays(const MotorLog& log, const ResponseProblem& response, DriveFit& fit) {
  constexpr double kClear = 4.0;    // standard deviations
  constexpr double kMatters = 0.1;  // rows
  fit.delays = response.delays(fit.theta);
  for (const std::size_t i : {kVoltageDelay, kCurrentDelay}) {
    const Estimate& e = fit.uncertainty.estimates[i];
    if (e.fixed || !e.identifiable) continue;
    const FittedDelay delay{i == kVoltageDelay ? "voltage_V" : "current_A",
                            log.velocity.empty() ? "current_A" : "velocity_rad_s", e.value, e.sd,
                            e.value / response.step()};
    fit.fitted_delays.push_back(delay);
    if (e.at_bound) {
      fit.warnings.push_back(
          fmt::format("{} seems to be more than {:.0f} rows apart from {}: put the channels on one "
                      "clock before fitting them",
                      delay.channel, std::floor(std::abs(delay.rows)), delay.against));
    } else if (std::abs(delay.rows) > kMatters && std::abs(delay.seconds) > kClear * delay.sd) {
      fit.warnings.push_back(fmt::format("{} comes {:.3g} ms ({:.2f} rows) {} than {}; the fit allows for it",
                                         delay.channel, 1e3 * std::abs(delay.seconds), std::abs(delay.rows),
                                         delay.rows > 0.0 ? "later" : "earlier", delay.against));
    }
  }
}

/// What the given motor's own uncertainty adds to the gearbox's.
void addMotorUncertainty(const LeastSquaresProblem& problem, const DriveFitOptions& options, DriveFit& fit) {
  if (options.fit_motor || !options.fit_gearbox) return;
  if (options.motor_covariance.size() == 0) {
    fit.warnings.emplace_back(
        "the motor's model states no uncertainty: the gearbox's intervals hold for exactly that motor only");
    return;
  }
  std::vector<int> held;
  for (std::size_t i = 0; i < kMotorParameters; ++i) held.push_back(static_cast<int>(i));
  addHeldUncertainty(problem, fit.theta, held, options.motor_covariance, fit.uncertainty);
}

DriveFit fitExtent(const MotorLog& log, DriveFitOptions options, DriveExtent extent, const std::vector<bool>& rows) {
  options.extent = extent;
  DriveFit fit;
  fit.extent = extent;
  const std::vector<std::string> missing = settleMissing(log, options, fit.warnings);
  fit.first_guess = driveFirstGuess(log, options);
  ResponseProblem response(log, options, rows);
  const LeastSquaresProblem problem = response.problem(fit.first_guess);
  fit.rows = response.rows();
  const std::size_t free = problem.freeParameters().size();
  if (fit.rows <= free) {
    throw DataError(fmt::format("{}: found {} rows for {} parameters, expected many more", log.file, fit.rows, free));
  }
  const auto measure = [&](std::span<const double> at) {
    std::vector<double> all(at.begin(), at.end());
    if (options.tie_constants) all[kKt] = all[kKe];
    return simulateDrive(log, motorOf(all), gearboxOf(all, options.ratio), response.delays(all), extent);
  };
  const LeastSquaresResult best = fitWeighted(log, problem, measure, rows, response, fit);
  if (!best.converged) fit.warnings.push_back("the fit stopped early: " + best.message);
  fit.theta = best.theta;
  if (options.tie_constants) fit.theta[kKt] = fit.theta[kKe];
  const LeastSquaresProblem found_problem = response.problem(fit.theta, /*given_too=*/!options.fit_motor);
  fit.uncertainty = estimateUncertainty(found_problem, fit.theta, response.labels());
  fit.uncertainty.n_effective /= static_cast<double>(response.channels());  // of rows, not of residuals
  // A delay of about 0 is hardly ever known to better than itself: that is no finding.
  std::erase_if(fit.uncertainty.findings, [](const std::string& sentence) {
    return sentence.find("_delay is hardly determined") != std::string::npos;
  });
  addMotorUncertainty(found_problem, options, fit);
  settleEstimates(fit.uncertainty, options, missing);
  if (options.fit_motor && !options.tie_constants) {
    const std::vector<Estimate>& all = fit.uncertainty.estimates;
    const std::string strange = strangeConstants(all[kKe], all[kKt]);
    if (!strange.empty()) fit.warnings.push_back(strange);
  }
  takeDelays(log, response, fit);
  const DriveResponse r = measure(fit.theta);
  const auto channel = [&](const char* name, const char* unit, const std::vector<double>& simulated,
                           const std::vector<double>& measured) {
    DriveChannel c{name, unit, rms(simulated, measured, rows), std::nullopt, standardDeviation(measured)};
    if (!rows.empty()) c.rms_heldout = rms(simulated, measured, rows, false);
    fit.channels.push_back(c);
  };
  if (response.hasVelocity()) channel("velocity", "rad_s", r.velocity, log.velocity);
  if (response.hasCurrent()) channel("current", "A", r.current, log.current);
  return fit;
}

/// Whether a simulated channel is off by clearly more than noise, and by much.
bool isMissed(const DriveChannel& channel, const std::vector<double>& measured) {
  constexpr double kClear = 3.0;    // noise levels
  constexpr double kMatters = 0.1;  // of the channel's spread
  return channel.rms > kClear * noiseLevel(measured) && channel.rms > kMatters * channel.spread;
}

/// What a motor that nothing loads does not explain of a log without a load; empty when it does. A torque that turns a
/// strong motor by little shows in its current.
std::string missedWithoutLoad(const MotorLog& log, const DriveFitOptions& options, const DriveFit& fit) {
  if (!options.fit_motor || varies(log.load)) return "";
  if (!varies(log.voltage) || !varies(log.current) || !varies(log.velocity)) return "";
  const DriveChannel &velocity = fit.channels[0], &current = fit.channels[1];
  if (!isMissed(velocity, log.velocity) && !isMissed(current, log.current)) return "";
  return fmt::format(
      "of a motor without load the simulated velocity is {:.3g} rad/s off the measured one ({:.2g} % of its spread; "
      "noise {:.2g} rad/s), the current {:.3g} A ({:.2g} %; {:.2g} A)",
      velocity.rms, 100.0 * velocity.rms / velocity.spread, noiseLevel(log.velocity), current.rms,
      100.0 * current.rms / current.spread, noiseLevel(log.current));
}

}  // namespace

std::vector<std::string> notFound(const Uncertainty& uncertainty) {
  std::vector<std::string> names;
  for (const Estimate& e : uncertainty.estimates) {
    if (std::isnan(e.value)) names.push_back(e.name);
  }
  return names;
}

DriveFit fitDrive(const MotorLog& log, const DriveFitOptions& options, const std::vector<bool>& rows) {
  constexpr double kExplains = 0.5;  // of the current's error is left when the velocity is given
  checkMotorLog(log);
  if (options.extent) return fitExtent(log, options, *options.extent, rows);
  DriveFit whole = fitExtent(log, options, DriveExtent::kWhole, rows);
  const std::string missed = missedWithoutLoad(log, options, whole);
  if (missed.empty()) return whole;
  DriveFit winding = fitExtent(log, options, DriveExtent::kWinding, rows);
  if (winding.channels.front().rms > kExplains * whole.channels.back().rms) {
    whole.warnings.push_back(missed +
                             ", and its winding alone does not explain the current either: intervals are too narrow");
    return whole;
  }
  const std::vector<std::string> unknown = notFound(winding.uncertainty);
  winding.warnings.insert(
      winding.warnings.begin(),
      fmt::format("something acts on the motor that the log does not hold: {}; R, L and K_E are those of the winding "
                  "alone at the measured velocity{}; record load_torque_Nm",
                  missed, unknown.empty() ? "" : fmt::format(", {} cannot be found", fmt::join(unknown, ", "))));
  return winding;
}

}  // namespace simgap
