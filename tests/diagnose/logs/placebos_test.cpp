// Surrogates keep the colour of a signal and lose its place.
#include "diagnose/logs/placebos.h"
#include "diagnose/surrogates.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnose/logs/held_out.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap {
namespace {

constexpr double kRowRate = 100.0;  // rows per second

/// A drive against a known torque. Its velocity is measured with noise, of which the controller makes current.
/// \param fed_back  current per speed of the noise, \param late  rows by which the current is logged late.
/// \param slow  size of a torque that follows no channel and no motion, such as a gust.
PreparedLog noisyDrive(double fed_back, int late, double slow = 0.0) {
  constexpr int kRows = 6000;
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<double> speed, torque, current;
  for (int i = 0; i < kRows; ++i) {
    const double t = i / kRowRate, w = 6.0 * std::sin(2.1 * t) + 3.0 * std::sin(3.7 * t + 1.0);
    const double seen = 0.4 * noise(random), load = 0.5 * std::sin(0.9 * t);
    torque.push_back(load);
    const double gust = slow * std::sin(0.37 * t + 2.0 * std::sin(0.11 * t));
    current.push_back(load + 0.2 * (w > 0.0 ? 1.0 : -1.0) + 0.1 * w - fed_back * seen + 0.02 * noise(random) + gust);
    speed.push_back(w + seen);
  }
  std::string csv = "time_s,motor_velocity_rad_s,external_torque_Nm,motor_current_A\n";
  for (int i = late; i < kRows; ++i) {
    const auto k = static_cast<std::size_t>(i);
    csv += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f}\n", i / kRowRate, speed[k], torque[k],
                       current[k - static_cast<std::size_t>(late)]);
  }
  return prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
}

struct DelayFit {
  double gain = 0.0;  ///< on the rows it was fitted to
  double delay = 0.0;
  std::string doubt;
};

DelayFit fitDelay(const PreparedLog& log) {
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
  const Fitted rest = search.fit({}, nullptr);
  const Trial trial = search.tryAll(rest, {{&actuator_effects::find("channel-delay"), {}, {}}})[0];
  return {trial.gain_training, trial.fitted.theta.back(), doubtOfDelay(search, trial.fitted, rest, 0)};
}

Eigen::VectorXd slowSignal(Eigen::Index n) {
  Eigen::VectorXd x(n);
  const Eigen::ArrayXd i = Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1));
  x = 2.0 + (0.05 * i).sin() + 0.5 * (0.113 * i + 1.0).sin();
  return x;
}

double alike(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::ArrayXd x = a.array() - a.mean(), y = b.array() - b.mean();
  return (x * y).sum() / std::sqrt(x.square().sum() * y.square().sum());
}

TEST(Placebos, KeepMeanSizeAndColour) {
  const Eigen::VectorXd x = slowSignal(4000), y = phaseRandomised(x, 3, 1);
  ASSERT_EQ(y.size(), x.size());
  EXPECT_NEAR(y.mean(), x.mean(), 1e-9);
  const auto power = [](const Eigen::VectorXd& v) { return (v.array() - v.mean()).square().mean(); };
  EXPECT_NEAR(power(y), power(x), 1e-6 * power(x));
  // As smooth as it was: neighbours are as alike.
  const auto neighbours = [](const Eigen::VectorXd& v) { return alike(v.head(v.size() - 1), v.tail(v.size() - 1)); };
  EXPECT_NEAR(neighbours(y), neighbours(x), 0.01);
}

TEST(Placebos, BelongToNoMotion) {
  const Eigen::VectorXd x = slowSignal(4000);
  double largest = 0.0;
  for (std::uint32_t draw = 0; draw < 20; ++draw) {
    largest = std::max(largest, std::abs(alike(x, phaseRandomised(x, draw, 1))));
  }
  EXPECT_LT(largest, 0.999);
  EXPECT_NE(phaseRandomised(x, 0, 1), phaseRandomised(x, 1, 1));
  EXPECT_EQ(phaseRandomised(x, 0, 1), phaseRandomised(x, 0, 1));
}

/// Share of the squared error on the training blocks that the model loses with the effect, and what the placebos'
/// linear step says of it. The effect has to be linear in what is left of it.
struct LinearGain {
  double fitted = 0.0, linear = 0.0;
};

LinearGain gainOfAsymmetry(double metres_per_radian) {
  std::string csv = "time_s,position_m,velocity_m_s,external_force_N,motor_force_N\n";
  for (int i = 0; i < 6000; ++i) {
    const double t = i / kRowRate, w = 4.0 * std::sin(2.1 * t), angle = -4.0 / 2.1 * std::cos(2.1 * t);
    const double load = 0.5 * std::sin(0.9 * t), away = t - 0.01 * (w > 0.0 ? 1.0 : -1.0);
    csv +=
        fmt::format("{:.2f},{:.12g},{:.12g},{:.6f},{:.6f}\n", t, metres_per_radian * angle, metres_per_radian * w, load,
                    load + std::tanh(9.0 * w) + 0.1 * w + 0.02 * std::abs(w) + 0.01 * std::cos(1e3 * away * t));
  }
  const PreparedLog log = prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
  const Fitted rest = search.fit({}, nullptr), full = search.fit({&actuator_effects::find("viscous-asymmetry")}, &rest);
  const auto error = [&](const Fitted& fitted) { return search.errors(fitted, search.training()).mse(); };
  return {1.0 - error(full) / error(rest), testPlacebos(search, full, rest, 0, 1).gain};
}

TEST(Placebos, GainOfACauseIsWhatItExplainsInAnyUnit) {
  for (const double metres_per_radian : {1.0, 1e-2, 1e-3}) {
    const LinearGain gain = gainOfAsymmetry(metres_per_radian);
    EXPECT_GT(gain.fitted, 0.2) << metres_per_radian;
    EXPECT_NEAR(gain.linear, gain.fitted, 0.02) << metres_per_radian;
  }
}

TEST(Placebos, TakeAnyLength) {
  for (const Eigen::Index n : {2, 7, 101, 997}) EXPECT_TRUE(phaseRandomised(slowSignal(n), 0, 1).allFinite()) << n;
}

TEST(Placebos, NoiseThatAControllerFeedsBackIsNoDelay) {
  const DelayFit fed_back = fitDelay(noisyDrive(0.3, 0));
  EXPECT_GT(fed_back.gain, 0.1);  // it fits better: that is the trap
  EXPECT_NE(fed_back.doubt, "") << "dt = " << fed_back.delay;
}

TEST(Placebos, ALateCurrentIsADelayWithAndWithoutSuchNoise) {
  for (const double fed_back : {0.0, 0.3}) {
    const DelayFit late = fitDelay(noisyDrive(fed_back, 4));
    // The noise that comes back bends the delay away from where it would be met.
    EXPECT_NEAR(late.delay, 4.0 / kRowRate, (fed_back > 0.0 ? 2.0 : 0.6) / kRowRate) << fed_back;
    EXPECT_EQ(late.doubt, "") << fed_back;
  }
}

TEST(Placebos, ALateCurrentIsADelayAlsoWhereSomethingSlowIsLeft) {
  const DelayFit late = fitDelay(noisyDrive(0.0, 4, 0.5));
  EXPECT_NEAR(late.delay, 4.0 / kRowRate, 1.0 / kRowRate);
  EXPECT_EQ(late.doubt, "");
  EXPECT_NE(fitDelay(noisyDrive(0.3, 0, 0.5)).doubt, "");
}

/// The effort comes 8 rows late forwards and in the same row backwards, as where a seal gives way one way only.
PreparedLog lateOneWay() {
  constexpr std::size_t kRows = 6000, kLate = 8;
  std::vector<double> speed, current;
  for (std::size_t i = 0; i < kRows; ++i) {
    const double t = static_cast<double>(i) / kRowRate, w = 6.0 * std::sin(2.1 * t) + 3.0 * std::sin(3.7 * t + 1.0);
    speed.push_back(w);
    current.push_back(0.2 * (w > 0.0 ? 1.0 : -1.0) + 0.1 * w + 0.5 * std::sin(0.9 * t) + 0.02 * std::cos(1e3 * t * t));
  }
  std::string csv = "time_s,motor_velocity_rad_s,external_torque_Nm,motor_current_A\n";
  for (std::size_t i = kLate; i < kRows; ++i) {
    const double t = static_cast<double>(i) / kRowRate;
    csv += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f}\n", t, speed[i], 0.5 * std::sin(0.9 * t),
                       current[speed[i] > 0.0 ? i - kLate : i]);
  }
  return prepareLog(CsvTable::parse(csv, "log.csv"), {}, ActuatorKind::kFriction);
}

TEST(Placebos, WhatIsLateInOneDirectionOnlyIsNoDelay) {
  const DelayFit one_way = fitDelay(lateOneWay());
  EXPECT_GT(one_way.gain, 0.1);
  EXPECT_NE(one_way.doubt.find("one time"), std::string::npos) << one_way.delay << one_way.doubt;
}

TEST(Placebos, WhatDelaysNothingIsNotDoubtedAsADelay) {
  const PreparedLog log = noisyDrive(0.0, 0);
  const LogDiagnosisOptions options;
  const LogSearch search(friction::find("coulomb"), log.data, splitLog(log, options).training, options);
  const Fitted rest = search.fit({}, nullptr);
  const Fitted full = search.fit({&actuator_effects::find("viscous-asymmetry")}, &rest);
  EXPECT_EQ(doubtOfDelay(search, full, rest, 0), "");
}

}  // namespace
}  // namespace simgap
