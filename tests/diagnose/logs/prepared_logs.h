/// \file
/// Small logs of simulated drives, ready for the pieces of a diagnosis.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <random>
#include <string>

#include "reality/drive_draws.h"
#include "simgap/diagnose/logs/log_diagnosis.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap::test {

inline reality::DriveRig smallRig(std::size_t rows = 3000) {
  reality::DriveRig rig = reality::drawRig(3);
  rig.rows = rows;
  return rig;
}

inline PreparedLog preparedLog(const reality::DriveRig& rig, const reality::DriveSecret& secret = {}) {
  return prepareLog(CsvTable::parse(reality::recordDrive(rig, secret).csv(), "log.csv"), {}, ActuatorKind::kFriction);
}

/// What diagnose says of a pendulum that hangs 0.5 kg from 0.2 m, as its bench knows, and swings slowly by up to 1.4
/// rad times `swing` about `middle` [rad]. \param torque  [N m] of angle, velocity and acceleration
template <typename Torque>
Diagnosis diagnosePendulum(double middle, double swing, Torque torque) {
  constexpr double kRate = 100.0, kGain = 0.8;  // [Hz], [N m / A]
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::string csv = "time_s,motor_position_rad,motor_velocity_rad_s,motor_current_A\n";
  for (int i = 0; i < 9000; ++i) {
    const double t = i / kRate, theta = middle + swing * (0.9 * std::sin(0.8 * t) + 0.5 * std::sin(0.31 * t + 1.0));
    const double w = swing * (0.72 * std::cos(0.8 * t) + 0.155 * std::cos(0.31 * t + 1.0));
    const double acceleration = -swing * (0.576 * std::sin(0.8 * t) + 0.04805 * std::sin(0.31 * t + 1.0));
    csv += fmt::format("{:.3f},{:.4f},{:.5f},{:.5f}\n", t, theta, w,
                       torque(theta, w, acceleration) / kGain + noise(random));
  }
  PreparedLog log = prepareLog(
      CsvTable::parse(csv, "log.csv"),
      readBench(YamlNode::parse(
          "format: simgap/bench/1\nload: pendulum\nmass_kg: 0.5\nlength_m: 0.2\nangle_offset_rad: 0\n", "rig.yaml")),
      ActuatorKind::kFriction);
  return diagnoseLog(subjectOf("coulomb"), log, {}).diagnosis;
}

}  // namespace simgap::test
