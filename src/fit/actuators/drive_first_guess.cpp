#include <algorithm>
#include <cmath>

#include "drive_parameters.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/optimize/separable.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  VectorXd result = VectorXd::Zero(channel.size());
  for (const Block& rows : splitRows(log.session, log.rows())) {
    if (rows.size() < 4) continue;
    const auto time = std::span(log.time).subspan(rows.begin, rows.size());
    const double rate = static_cast<double>(rows.size() - 1) / (time.back() - time.front());
    const auto d = differentiate(time, smooth(time, std::span(channel).subspan(rows.begin, rows.size()), 0.1 * rate));
    std::ranges::copy(d, result.begin() + static_cast<std::ptrdiff_t>(rows.begin));
  }
  return result;
}

/// The multiple regressions of 000: V on (i, di/dt, w), then the torque balance on (dw/dt, w, sign w).
class FirstGuess {
 public:
  FirstGuess(const MotorLog& log, const DriveFitOptions& options) : log_(log), options_(options) {}

  std::vector<double> theta() {
    theta_ = {1.0, 1e-3, 0.05, 0.05, 1e-5, 1e-6, 1e-3, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
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
    fixValues(driveParameters(options_), options_.fixed, theta_);
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
    for (Index i = 0; i < w.size(); ++i) sign[i] = held.direction[i];
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
    for (Index i = 0; i < w.size(); ++i) sign[i] = held.direction[i];
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

}  // namespace

std::vector<double> driveFirstGuess(const MotorLog& log, const DriveFitOptions& options) {
  return FirstGuess(log, options).theta();
}

}  // namespace simgap
