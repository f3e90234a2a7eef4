#include "simgap/fit/drive_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drive_response.h"
#include "simgap/core/error.h"
#include "simgap/fit/separable.h"
#include "simgap/measure/log_checks.h"
#include "simgap/measure/motion.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

enum Parameter : std::size_t { kR, kL, kKe, kKt, kJm, kMuM, kTauM, kEta, kTauG, kMuG, kJg, kCount };
constexpr std::size_t kFirstOfGearbox = kEta;

std::vector<FitParameter> allParameters(const DriveFitOptions& options) {
  constexpr double kTiny = 1e-12, kInf = std::numeric_limits<double>::infinity();
  std::vector<FitParameter> all = {
      {"R", "ohm", kTiny, kInf},    {"L", "H", kTiny, kInf},       {"K_E", "Vs", kTiny, kInf},
      {"K_T", "Nm_A", kTiny, kInf}, {"J_M", "kg_m2", kTiny, kInf}, {"mu_M", "Nms", 0.0, kInf},
      {"tau_CM", "Nm", 0.0, kInf},  {"eta", "1", 1e-3, 1.0},       {"tau_CG", "Nm", 0.0, kInf},
      {"mu_G", "Nms", 0.0, kInf},   {"J_G", "kg_m2", 0.0, kInf}};
  for (std::size_t i = 0; i < kCount; ++i) {
    FitParameter& p = all[i];
    const auto bounds = options.bounds.find(p.name);
    if (bounds != options.bounds.end()) {
      p.lower = bounds->second.lower;
      p.upper = bounds->second.upper;
    }
    p.fixed = i < kFirstOfGearbox ? !options.fit_motor : !options.fit_gearbox;
    if (options.fixed.contains(p.name)) p.fixed = true;
  }
  return all;
}

/// Non-negative least squares of target ~ columns; the coefficients.
VectorXd regress(const MatrixXd& columns, const VectorXd& target) {
  MatrixXd all(columns.rows(), columns.cols() + 1);
  all << columns, target;
  const std::vector<LinearTerm> terms(static_cast<std::size_t>(columns.cols()));
  return solveBounded(all.transpose() * all, terms).coefficients;
}

VectorXd column(const std::vector<double>& v) {
  return Eigen::Map<const VectorXd>(v.data(), static_cast<Index>(v.size()));
}

/// d/dt per session, of a channel smoothed at a tenth of the sampling rate.
VectorXd slope(const MotorLog& log, const std::vector<double>& channel) {
  VectorXd result = VectorXd::Zero(static_cast<Index>(channel.size()));
  for (const Block& rows : splitRows(log.session, log.rows())) {
    if (rows.size() < 4) continue;
    const auto time = std::span(log.time).subspan(rows.begin, rows.size());
    const double rate = static_cast<double>(rows.size() - 1) / (time.back() - time.front());
    const auto d = differentiate(time, smooth(time, std::span(channel).subspan(rows.begin, rows.size()), 0.1 * rate));
    std::ranges::copy(d, result.begin() + static_cast<std::ptrdiff_t>(rows.begin));
  }
  return result;
}

bool varies(const std::vector<double>& channel) { return !channel.empty() && !isConstant(channel); }

/// The multiple regressions of 000: V on (i, di/dt, w), then the torque balance on (dw/dt, w, sign w).
class FirstGuess {
 public:
  FirstGuess(const MotorLog& log, const DriveFitOptions& options) : log_(log), options_(options) {}

  std::vector<double> theta() {
    theta_ = {1.0, 1e-3, 0.05, 0.05, 1e-5, 1e-6, 1e-3, 1.0, 0.0, 0.0, 0.0};
    const Motor& m = options_.motor;
    if (!options_.fit_motor) {
      theta_[kR] = m.resistance, theta_[kL] = m.inductance, theta_[kKe] = m.back_emf_constant;
      theta_[kKt] = m.torque_constant, theta_[kJm] = m.inertia, theta_[kMuM] = m.viscous_friction;
      theta_[kTauM] = m.coulomb_friction;
    }
    applyFixed();
    velocity_ = speeds();
    if (options_.fit_motor) electrical();
    applyFixed();
    if (options_.fit_motor) mechanical();
    if (options_.fit_gearbox) gearing();
    applyFixed();
    return theta_;
  }

 private:
  void applyFixed() {
    const std::vector<FitParameter> parameters = allParameters(options_);
    for (std::size_t i = 0; i < kCount; ++i) {
      if (const auto fixed = options_.fixed.find(parameters[i].name); fixed != options_.fixed.end()) {
        theta_[i] = fixed->second;
      }
    }
    if (options_.tie_constants) theta_[kKt] = theta_[kKe];
  }

  /// Logged, or from the voltage that the winding does not take.
  std::vector<double> speeds() const {
    if (!log_.velocity.empty()) return log_.velocity;
    std::vector<double> w(log_.rows());
    for (std::size_t i = 0; i < w.size(); ++i) w[i] = (log_.voltage[i] - theta_[kR] * log_.current[i]) / theta_[kKe];
    return w;
  }

  void electrical() {
    if (log_.voltage.empty()) return;
    const VectorXd v = column(log_.voltage);
    if (log_.current.empty()) {
      theta_[kKe] = std::max(regress(column(velocity_), v)[0], 1e-9);
    } else if (!log_.velocity.empty()) {
      MatrixXd x(v.size(), 3);
      x << column(log_.current), slope(log_, log_.current), column(velocity_);
      const VectorXd c = regress(x, v);
      theta_[kR] = std::max(c[0], 1e-9);
      theta_[kL] = c[1] > 0.0 ? c[1] : 1e-3 * theta_[kR];
      theta_[kKe] = std::max(c[2], 1e-9);
    }
    theta_[kKt] = theta_[kKe];
  }

  void mechanical() {
    const VectorXd w = column(velocity_), dw = slope(log_, velocity_);
    VectorXd sign(w.size());
    const MotionSign held = holdSign(velocity_);
    for (Index i = 0; i < w.size(); ++i) sign[i] = held.direction[static_cast<std::size_t>(i)];
    VectorXd i_a =
        log_.current.empty() ? VectorXd((column(log_.voltage) - theta_[kKe] * w) / theta_[kR]) : column(log_.current);
    VectorXd c;
    const bool known = options_.fixed.contains("K_T") || options_.tie_constants;
    if (varies(log_.load) && !known) {
      MatrixXd x(w.size(), 4);
      x << column(log_.load), dw, w, sign;  // i = (T + J dw + mu w + tau sign) / K_T
      c = regress(x, i_a);
      const double per_ampere = std::max(c[0], 1e-12);
      theta_[kKt] = 1.0 / per_ampere;
      c = VectorXd(c.tail(3) / per_ampere);
    } else {
      MatrixXd x(w.size(), 3);
      x << dw, w, sign;
      const VectorXd load = log_.load.empty() ? VectorXd::Zero(w.size()) : column(log_.load);
      c = regress(x, theta_[kKt] * i_a - load);
    }
    if (c[0] > 0.0) theta_[kJm] = c[0];
    theta_[kMuM] = c[1];
    theta_[kTauM] = c[2];
  }

  void gearing() {
    const double n = options_.ratio;
    const VectorXd w = column(velocity_), dw = slope(log_, velocity_);
    VectorXd sign(w.size());
    const MotionSign held = holdSign(velocity_);
    for (Index i = 0; i < w.size(); ++i) sign[i] = held.direction[static_cast<std::size_t>(i)];
    const VectorXd inner =
        theta_[kKt] * column(log_.current) - theta_[kJm] * dw - theta_[kMuM] * w - theta_[kTauM] * sign;
    MatrixXd x(w.size(), 4);  // 000 eq. 11: T = N eta tau_LM - tau_CG - mu_G w_G - J_G dw_G/dt
    x << n * inner, -sign, -w / n, -dw / n;
    const VectorXd c = regress(x, column(log_.load));
    theta_[kEta] = std::clamp(c[0], 0.05, 1.0);
    theta_[kTauG] = c[1];
    theta_[kMuG] = c[2];
    theta_[kJg] = c[3];
  }

  const MotorLog& log_;
  const DriveFitOptions& options_;
  std::vector<double> theta_, velocity_;
};

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
    problem.parameters = allParameters(options_);
    if (options_.tie_constants) problem.parameters[kKt].fixed = true;
    problem.chunks = chunks_;
    problem.evaluate = [this](std::span<const double> theta, const Block& chunk, Eigen::Ref<VectorXd> residual,
                              Eigen::Ref<MatrixXd>* jacobian) {
      evaluate(theta, chunk, residual);
      if (jacobian == nullptr) return;
      std::vector<FitParameter> parameters = allParameters(options_);
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
  const VectorXd v = column(values);
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

}  // namespace

Motor motorOf(std::span<const double> theta) {
  return {theta[kR], theta[kL], theta[kKe], theta[kKt], theta[kJm], theta[kMuM], theta[kTauM], 0.0};
}

Gearbox gearboxOf(std::span<const double> theta, double ratio) {
  return {ratio, theta[kEta], theta[kJg], theta[kMuG], theta[kTauG]};
}

DriveFit fitDrive(const MotorLog& log, const DriveFitOptions& given, const std::vector<bool>& held) {
  checkMotorLog(log);
  DriveFitOptions options = given;
  DriveFit fit;
  const std::vector<std::string> missing = settleMissing(log, options, fit.warnings);
  fit.rows = log.rows();
  fit.first_guess = FirstGuess(log, options).theta();
  ResponseProblem response(log, options, held);
  const LeastSquaresProblem problem = response.problem();
  const std::size_t free = problem.freeParameters().size();
  if (log.rows() <= free) {
    throw DataError(fmt::format("{}: found {} rows for {} parameters, expected many more", log.file, log.rows(), free));
  }
  std::vector<double> theta = fit.first_guess;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    if (!problem.parameters[i].fixed) {
      theta[i] = std::clamp(std::max(theta[i], 1e-9), problem.parameters[i].lower, problem.parameters[i].upper);
    }
  }
  const auto measure = [&](std::span<const double> at) {
    std::vector<double> all(at.begin(), at.end());
    if (options.tie_constants) all[kKt] = all[kKe];
    return simulateDrive(log, motorOf(all), gearboxOf(all, options.ratio));
  };
  // Several starts: the regression, and mechanical parameters off by a factor; the channels' weights follow the fit.
  response.velocityScale = response.hasVelocity() ? spread(log.velocity) : 1.0;
  response.currentScale = response.hasCurrent() ? spread(log.current) : 1.0;
  LeastSquaresOptions rough;
  rough.max_iterations = 40;
  rough.function_tolerance = 1e-8;
  std::vector<LeastSquaresResult> found;
  for (const double factor : {1.0, 0.3, 3.0}) {
    std::vector<double> start = theta;
    for (const std::size_t i : {kJm, kMuM, kTauM, kMuG, kTauG, kJg})
      start[i] *= problem.parameters[i].fixed ? 1.0 : factor;
    found.push_back(minimise(problem, start, rough));
  }
  std::ranges::stable_sort(found, {}, &LeastSquaresResult::cost);
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
  if (options.tie_constants) {
    Estimate& torque = fit.uncertainty.estimates[kKt];
    const Estimate& emf = fit.uncertainty.estimates[kKe];
    torque.value = emf.value, torque.sd = emf.sd, torque.lower95 = emf.lower95, torque.upper95 = emf.upper95;
  }
  for (Estimate& e : fit.uncertainty.estimates) {
    if (std::ranges::find(missing, e.name) == missing.end()) continue;
    e.value = e.sd = e.lower95 = e.upper95 = std::nan("");
    e.fixed = e.identifiable = false;
  }
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
