/// How often 95 % intervals hold the truth: logs of independent simulators with late channels, converters' steps and
/// noise that remembers. The whole study (SlowIntervalCoverage) takes 40 logs of each kind; the quick one a few.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "reality/drive_rig.h"
#include "reality/friction_log.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"
#include "reality/sticking_pendulum.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/actuators/drive_fit.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/fit/actuators/pam_fit.h"

namespace simgap::test {
namespace {

using reality::MotorDesign;
using reality::MotorTruth;

/// Counts over logs, by parameter.
class Coverage {
 public:
  void add(const std::vector<Estimate>& estimates, const std::map<std::string, double>& truth) {
    for (const Estimate& e : estimates) {
      const auto value = truth.find(e.name);
      if (value == truth.end()) continue;
      EXPECT_TRUE(e.lower95 <= e.value && e.value <= e.upper95)
          << e.name << " " << e.lower95 << " " << e.value << " " << e.upper95;
      Count& count = counts_[e.name];
      ++count.logs;
      count.held += e.lower95 <= value->second && value->second <= e.upper95 ? 1 : 0;
      if (e.at_bound) continue;
      const double error = e.value - value->second;
      count.sum += error, count.squares += error * error, count.variance += e.sd * e.sd;
      count.standardised.push_back(std::abs(error) / e.sd);
    }
  }

  /// Of all parameters together.
  double share() const {
    double held = 0.0, logs = 0.0;
    for (const auto& [name, count] : counts_) held += count.held, logs += count.logs;
    return held / logs;
  }

  void print(const char* title) const {
    for (const auto& [name, c] : counts_) {
      std::printf("%s %-8s held in %2.0f of %2.0f, spread / stated sd %.2f, bias / sd %+.2f\n", title, name.c_str(),
                  c.held, c.logs, std::sqrt(c.squares / c.variance), c.sum / std::sqrt(c.logs * c.variance));
    }
    std::printf("%s all      %.1f %%\n", title, 100.0 * share());
  }

  /// Of 40 intervals that hold with 95 % fewer than 34 hold in 0.3 % of studies.
  void expectHonest(const char* title) const {
    print(title);
    for (const auto& [name, c] : counts_) {
      EXPECT_GE(c.held, 0.85 * c.logs) << title << " " << name;
      // An interval that is honest because it says nothing is no use either: of what is normal the median is 0.67.
      EXPECT_GT(upperMedian(c.standardised), 0.34) << title << " " << name;
    }
    EXPECT_GE(share(), 0.91) << title;
  }

 private:
  struct Count {
    double logs = 0.0, held = 0.0, sum = 0.0, squares = 0.0, variance = 0.0;
    std::vector<double> standardised;
  };
  std::map<std::string, Count> counts_;
};

MotorDesign bench(int seed) {
  MotorDesign design;
  design.seconds = 3.0;
  design.step = 4e-6;  // the reference must be better than the intervals are narrow
  design.current_noise = 0.05;
  design.velocity_noise = 2.0;
  design.noise_memory = 0.5;
  design.current_late = 0.06 * (seed % 16);
  design.voltage_late = 0.09 * (seed % 13);
  design.voltage_grain = 0.006;  // 12 bits of 24 V
  design.current_grain = 0.02;
  design.velocity_grain = 1.0;
  design.seed = static_cast<std::uint64_t>(1000 + seed);
  return design;
}

MotorLog motorLog(const MotorTruth& truth, const MotorDesign& design) {
  return readMotorLog(CsvTable::parse(simulateMotor(truth, design).csv(), "motor.csv"));
}

std::map<std::string, double> motorTruth(const MotorTruth& m) {
  return {{"R", m.resistance}, {"L", m.inductance}, {"K_E", m.emf},       {"K_T", m.torque},
          {"J_M", m.inertia},  {"mu_M", m.viscous}, {"tau_CM", m.coulomb}};
}

Coverage motors(int logs) {
  Coverage coverage;
  const MotorTruth truth;
  for (int seed = 0; seed < logs; ++seed) {
    const DriveFit fit = fitDrive(motorLog(truth, bench(seed)), {});
    coverage.add(fit.uncertainty.estimates, motorTruth(truth));
    EXPECT_LE(fit.uncertainty.n_effective, static_cast<double>(fit.rows));
    for (const FittedDelay& delay : fit.fitted_delays) {
      const MotorDesign design = bench(seed);
      // A voltage that steps between two samples is first seen in the second.
      const double late = delay.channel == "voltage_V" ? std::ceil(design.voltage_late) : design.current_late;
      EXPECT_NEAR(delay.rows, late, 0.05) << delay.channel << " " << seed;
    }
  }
  return coverage;
}

/// A gearbox behind a motor that is known from a log of its own, and no better.
Coverage gearboxes(int logs) {
  Coverage coverage;
  MotorTruth truth;
  for (int seed = 0; seed < logs; ++seed) {
    MotorDesign alone = bench(seed);
    alone.seconds = 1.0;
    alone.sessions = 1;
    const DriveFit motor = fitDrive(motorLog({}, alone), {});
    truth.ratio = 50.0, truth.efficiency = 0.75;
    truth.gear_coulomb = 0.05, truth.gear_viscous = 0.004, truth.gear_inertia = 2e-3;
    MotorDesign geared = bench(seed + 500);
    geared.load = 0.4;
    DriveFitOptions options;
    options.fit_motor = false, options.fit_gearbox = true;
    options.ratio = truth.ratio;
    options.motor = motorOf(motor.theta);
    options.motor_covariance = motor.uncertainty.covariance.topLeftCorner(7, 7);
    const DriveFit fit = fitDrive(motorLog(truth, geared), options);
    coverage.add(fit.uncertainty.estimates, {{"eta", truth.efficiency},
                                             {"tau_CG", truth.gear_coulomb},
                                             {"mu_G", truth.gear_viscous},
                                             {"J_G", truth.gear_inertia}});
  }
  return coverage;
}

FrictionData frictionData(const std::string& csv, const Bench& bench = {}) {
  return prepareFrictionData(readActuatorLog(CsvTable::parse(csv, "log.csv"), {}), bench, {});
}

Coverage frictions(int logs, double current_late) {
  Coverage coverage;
  reality::FrictionTruth truth;
  truth.sliding_offset = truth.breakaway_offset = 0.6;
  truth.noise = 0.3, truth.noise_memory = 0.6;
  truth.current_grain = 0.05;
  truth.velocity_noise = 0.1;
  truth.current_late = current_late;
  for (int seed = 0; seed < logs; ++seed) {
    const FrictionData data = frictionData(
        simulateFrictionLog(truth, {.rows = 12000, .seed = static_cast<std::uint64_t>(2000 + seed)}).csv());
    const FrictionFit fit = fitFriction(friction::find("variant-b"), data, {});
    coverage.add(fit.uncertainty.estimates, {{"k_a", truth.torque_per_ampere},
                                             {"n_c1", truth.sliding_per_load},
                                             {"n_c2", truth.sliding_offset},
                                             {"n_s1", truth.breakaway_per_load},
                                             {"n_s2", truth.breakaway_offset},
                                             {"k_v", truth.viscous},
                                             {"v_s", truth.stribeck_velocity},
                                             {"delta", truth.stribeck_exponent}});
    EXPECT_LE(fit.uncertainty.n_effective, static_cast<double>(fit.n));
  }
  return coverage;
}

/// Drives whose rotor takes a part of the current that no sensor at the joint sees: its torque goes with that of a
/// weight that swings.
Coverage rotors(int logs) {
  Coverage coverage;
  for (int seed = 0; seed < logs; ++seed) {
    reality::DriveRig rig;
    rig.rows = 15000, rig.seed = static_cast<std::uint64_t>(4000 + seed);
    reality::DriveSecret secret;
    secret.inertia = 0.01;
    const FrictionData data = frictionData(recordDrive(rig, secret).csv());
    const FrictionFit fit = fitFriction(friction::find("classic"), data, {});
    coverage.add(fit.uncertainty.estimates, {{"k_a", rig.torque_per_ampere},
                                             {"n_c", rig.sliding},
                                             {"n_s", rig.breakaway},
                                             {"k_v", rig.viscous},
                                             {"v_s", rig.stribeck_speed},
                                             {"delta", rig.stribeck_power}});
    const auto named = [](const std::string& warning) { return warning.find("inertia") != std::string::npos; };
    EXPECT_EQ(std::ranges::count_if(fit.warnings, named), 1) << seed;
  }
  return coverage;
}

Coverage muscles(int logs) {
  Coverage coverage;
  reality::PamTruth truth;
  truth.tendon = 12000.0;
  // 002 eq. 12 of the braid that the rig is made of.
  const double q = std::acos(-1.0) * truth.rest_diameter * truth.rest_diameter / 4.0;
  const double t = std::pow(std::tan(truth.braid_angle), 2), s = std::pow(std::sin(truth.braid_angle), 2);
  for (int seed = 0; seed < logs; ++seed) {
    reality::PamDesign design;
    design.noise_memory = 0.5;
    design.pressure_late = 0.05 * (seed % 20);
    design.pressure_grain = 150.0, design.force_grain = 1.0;
    design.seed = static_cast<std::uint64_t>(3000 + seed);
    const PamLog log = readPamLog(CsvTable::parse(recordPam(truth, design).csv(), "pam.csv"));
    const PamFit fit = fitPam(log, {.spring = true, .tied = false, .fixed = {}, .bounds = {}});
    coverage.add(fit.uncertainty.estimates,
                 {{"a", 3.0 * q / t}, {"b", -6.0 * q / t}, {"c", q * (3.0 / t - 1.0 / s)}, {"k", truth.tendon}});
  }
  return coverage;
}

/// Benches whose joint sticks, with an encoder, or a velocity besides.
Coverage benches(int count, std::uint64_t first, bool logs_velocity) {
  Coverage coverage;
  for (int k = 0; k < count; ++k) {
    reality::StickingPendulum bench = reality::drawStickingPendulum(first + static_cast<std::uint64_t>(k));
    bench.logs_velocity = logs_velocity;
    const FrictionData data = frictionData(bench.csv(), readBench(YamlNode::parse(bench.benchYaml(), "bench.yaml")));
    coverage.add(fitFriction(friction::find("stribeck"), data, {}).uncertainty.estimates, bench.truth());
  }
  return coverage;
}

TEST(IntervalCoverage, IntervalsOfMotorAndGearboxHoldTheTruth) {
  // Of 28 and 16 intervals that hold with 95 %, fewer than 24 and 13 hold in 1 % of studies.
  const Coverage motor = motors(4), gearbox = gearboxes(4);
  motor.print("motor"), gearbox.print("gearbox");
  EXPECT_GE(motor.share(), 0.85);
  EXPECT_GE(gearbox.share(), 0.8);
}

TEST(IntervalCoverage, IntervalsOfFrictionAndMuscleHoldTheTruth) {
  const Coverage friction = frictions(4, 0.0), muscle = muscles(6);
  friction.print("friction"), muscle.print("muscle");
  EXPECT_GE(friction.share(), 0.85);
  EXPECT_GE(muscle.share(), 0.8);
}

// Where a joint stops and turns its acceleration jumps, and a smoother does not: of 84 intervals 29 held the truth.
TEST(IntervalCoverage, IntervalsOfABenchThatSticksHoldTheTruth) {
  const Coverage coverage = benches(6, 201, false);
  coverage.print("bench");
  EXPECT_GE(coverage.share(), 0.85);
}

TEST(IntervalCoverage, IntervalsHoldTheTruthBesideARotorThatTheLoadDoesNotHold) {
  const Coverage coverage = rotors(6);
  coverage.print("rotor");
  EXPECT_GE(coverage.share(), 0.85);
}

TEST(IntervalCoverage, WithoutTheMotorsUncertaintyAGearboxIsKnownTooWell) {
  const MotorTruth truth{
      .ratio = 50.0, .efficiency = 0.75, .gear_coulomb = 0.05, .gear_viscous = 0.004, .gear_inertia = 2e-3};
  MotorDesign geared = bench(1);
  geared.load = 0.4;
  const MotorLog log = motorLog(truth, geared);
  DriveFitOptions options;
  options.fit_motor = false, options.fit_gearbox = true;
  options.ratio = truth.ratio;
  options.motor = {truth.resistance, truth.inductance, truth.emf,     truth.torque,
                   truth.inertia,    truth.viscous,    truth.coulomb, 0.0};
  const auto eta = [&] {
    const DriveFit fit = fitDrive(log, options);
    return fit.uncertainty.estimates[7];
  };
  options.motor_covariance = Eigen::MatrixXd::Zero(7, 7);
  const Estimate alone = eta();
  // K_T known to 2 %: torque = N eta K_T i, so eta cannot be known to better.
  options.motor_covariance(3, 3) = std::pow(0.02 * truth.torque, 2);
  const Estimate whole = eta();
  EXPECT_EQ(alone.value, whole.value);
  EXPECT_GT(whole.sd, 0.6 * 0.02 * truth.efficiency);
  EXPECT_GT(whole.sd, 1.5 * alone.sd);
  EXPECT_GT(whole.upper95 - whole.lower95, 1.5 * (alone.upper95 - alone.lower95));
}

TEST(SlowIntervalCoverage, Motors) { motors(40).expectHonest("motor"); }
TEST(SlowIntervalCoverage, Gearboxes) { gearboxes(40).expectHonest("gearbox"); }
TEST(SlowIntervalCoverage, Frictions) { frictions(40, 0.0).expectHonest("friction"); }
TEST(SlowIntervalCoverage, FrictionsWithALateCurrent) { frictions(40, 0.3).expectHonest("friction, late current"); }
TEST(SlowIntervalCoverage, BenchesThatStick) { benches(40, 1, false).expectHonest("bench"); }
TEST(SlowIntervalCoverage, BenchesThatStickWithAVelocity) { benches(40, 101, true).expectHonest("bench, velocity"); }
TEST(SlowIntervalCoverage, Muscles) { muscles(40).expectHonest("muscle"); }

}  // namespace
}  // namespace simgap::test
