#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drive_parameters.h"
#include "opposite_sign.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/motion.h"

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
    if (options_.fit_motor) electrical();
    applyFixed();
    velocity_ = speeds();
    const MatrixXd x = balance();
    requireSigns(x);
    if (options_.fit_motor) mechanical(x);
    if (options_.fit_gearbox) gearing(x);
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
      theta_[kKe] = std::max(regress(column(log_.velocity), v)[0], 1e-9);
    } else if (!log_.velocity.empty()) {
      MatrixXd x(v.size(), 3);
      x << column(log_.current), slope(log_, log_.current), column(log_.velocity);
      const VectorXd c = regress(x, v);
      theta_[kR] = std::max(c[0], 1e-9);
      theta_[kL] = c[1] > 0.0 ? c[1] : 1e-3 * theta_[kR];
      theta_[kKe] = std::max(c[2], 1e-9);
    } else {
      speedless(v);
    }
    theta_[kKt] = theta_[kKe];
  }

  /// K_E w = V - R i in the torque balance, with K = K_E = K_T:
  /// (K + mu R / K) i = T + J / K dV/dt - J R / K di/dt + mu / K V + tau sign(V).
  void speedless(const VectorXd& v) {
    MatrixXd x(v.size(), 5);
    x << load(), slope(log_, log_.voltage), -slope(log_, log_.current), v, heldSign(log_.voltage);
    const bool loaded = varies(log_.load);
    const VectorXd c = regress(x.rightCols(loaded ? 5 : 4), column(log_.current));
    const double per_voltage = c[loaded ? 1 : 0], per_current = c[loaded ? 2 : 1];
    if (per_voltage > 0.0 && per_current > 0.0) theta_[kR] = per_current / per_voltage;
    if (loaded && options_.tie_constants) theta_[kKe] = torquePerAmpere(c[0]);
    theta_[kL] = 1e-3 * theta_[kR];
  }

  VectorXd load() const {
    return log_.load.empty() ? VectorXd(VectorXd::Zero(std::ssize(log_.time))) : column(log_.load);
  }

  static VectorXd heldSign(const std::vector<double>& velocity) {
    const MotionSign held = holdSign(velocity);
    VectorXd sign(std::ssize(velocity));
    for (Index i = 0; i < sign.size(); ++i) sign[i] = held.direction[i];
    return sign;
  }

  /// Columns of the torque balance, i = c_0 T + c_1 dw/dt + c_2 w + c_3 sign(w), shape (rows, 4).
  MatrixXd balance() const {
    MatrixXd x(log_.rows(), 4);
    x << load(), slope(log_, velocity_), column(velocity_), heldSign(velocity_);
    return x;
  }

  /// Logged, or what the winding draws.
  VectorXd current() const {
    if (!log_.current.empty()) return column(log_.current);
    return (column(log_.voltage) - theta_[kKe] * column(velocity_)) / theta_[kR];
  }

  /// Refuses a channel that was recorded with the opposite sign: with it turned round the torque balance, of a motor
  /// and of a gearbox alike, explains the current.
  void requireSigns(const MatrixXd& balance) const {
    if (!varies(log_.load)) return;
    MatrixXd all(balance.rows(), balance.cols() + 2);
    all << balance, VectorXd::Ones(balance.rows()), current();
    const MatrixXd gram = all.transpose() * all;
    std::vector<LinearTerm> terms(static_cast<std::size_t>(balance.cols()) + 1);
    terms.back().lower = -std::numeric_limits<double>::infinity();
    const auto costWith = [&](Index first, Index count) {
      VectorXd signs = VectorXd::Ones(all.cols());
      signs.segment(first, count).setConstant(-1.0);
      return costTurned(gram, signs, terms);
    };
    struct Turned {
      const char* channel;
      double cost;
    };
    std::vector<Turned> turned = {{"load_torque_Nm", costWith(0, 1)}};
    if (!log_.current.empty() && !log_.velocity.empty()) {
      turned.push_back({"current_A", costWith(all.cols() - 1, 1)});
      if (goesBothWays(balance.col(3).array())) turned.push_back({"velocity_rad_s", costWith(1, 3)});
    }
    const Turned& best = *std::ranges::min_element(turned, {}, &Turned::cost);
    const double as_it_is = costWith(0, 0);
    if (!(best.cost < kOtherSign * as_it_is)) return;
    const auto rms = [&](double cost) { return std::sqrt(std::max(cost, 0.0) / static_cast<double>(all.rows())); };
    throw DataError(fmt::format(
        "{}: {} has the opposite sign: turned round, load and friction explain the current to {:.3g} A, as it is to "
        "{:.3g}; {}",
        log_.file, best.channel, rms(best.cost), rms(as_it_is), turnItRound(best.channel)));
  }

  /// \param amperes  per torque of the load
  double torquePerAmpere(double amperes) const {
    if (amperes > 0.0) return 1.0 / amperes;
    throw DataError(log_.file +
                    ": what drives the motor does not grow with load_torque_Nm, so K_T cannot be found: check both "
                    "channels and their signs (--map load_torque_Nm=COLUMN*-1 turns one), or fix it (--fix K_T=…)");
  }

  void mechanical(const MatrixXd& x) {
    const VectorXd i_a = current();
    VectorXd c;
    const bool known = options_.fixed.contains("K_T") || options_.tie_constants;
    if (varies(log_.load) && !known) {
      c = regress(x, i_a);  // i = (T + J dw + mu w + tau sign) / K_T
      theta_[kKt] = torquePerAmpere(c[0]);
      c = VectorXd(c.tail(3) / c[0]);
    } else {
      c = regress(x.rightCols(3), theta_[kKt] * i_a - x.col(0));
    }
    if (c[0] > 0.0) theta_[kJm] = c[0];
    theta_[kMuM] = c[1];
    theta_[kTauM] = c[2];
  }

  void gearing(const MatrixXd& balance) {
    const double n = options_.ratio;
    const auto dw = balance.col(1), w = balance.col(2), sign = balance.col(3);
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
