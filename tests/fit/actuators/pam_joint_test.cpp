// A muscle's parameters from the log of a joint: angle, pressures and torque, no contraction and no single force.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reality/exo_joint_rig.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/pam_comparison.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

/// Of the rig of tests/reality.
const MusclePulley kPulley{0.04, 0.25, 0.12, 0.12};

std::string jointLog(double noise, bool both) {
  reality::ExoRig rig;
  rig.hysteresis = 0.0;
  const auto inputs = [both](double t) -> std::array<double, 4> {
    return {3e5 + 2.5e5 * std::sin(1.6 * t), both ? 2.5e5 + 2e5 * std::sin(1.1 * t + 1.3) : 0.0, 0.0,
            both ? 0.0 : -15.0 + 10.0 * std::sin(2.3 * t)};
  };
  return reality::recordExoRig(rig, inputs, 16.0, 25.0, 5e-4).csv(noise, 0.0, 0.0, 3);
}

PamLog readJoint(const std::string& text) { return readJointPamLog(CsvTable::parse(text, "joint.csv"), kPulley); }

/// 002 eq. 12, of a rig's diameter and braid angle.
void expectRig(const PamFit& fit, double tolerance) {
  const reality::ExoRig rig;
  const double area = std::numbers::pi * rig.diameter * rig.diameter / 4.0;
  const double cot2 = 1.0 / std::pow(std::tan(rig.braid_angle), 2);
  EXPECT_NEAR(fit.theta[0] / (3.0 * area * cot2), 1.0, tolerance);
  EXPECT_NEAR(fit.theta[1] / (-6.0 * area * cot2), 1.0, tolerance);
  EXPECT_NEAR(fit.theta[2] / (area * (2.0 * cot2 - 1.0)), 1.0, tolerance);
  EXPECT_NEAR(fit.theta[3] / rig.tendon, 1.0, tolerance);
}

TEST(JointPamLog, TwoMusclesAreFoundFromTheirDifference) {
  const PamLog log = readJoint(jointLog(0.0, true));
  ASSERT_TRUE(log.opposed());
  PamFitOptions options;
  options.tied = true;
  expectRig(fitPam(log, options), 2e-3);  // torques are logged to 1e-4 N m, angles to 1e-5 rad
}

TEST(JointPamLog, ATurnedTorqueIsNamed) {
  for (const bool both : {true, false}) {
    PamLog log = readJoint(jointLog(0.1, both));
    for (double& force : log.force) force = -force;
    EXPECT_THAT(errorOf([&] { fitPam(log, {}); }), HasSubstr("_Nm has the opposite sign")) << both;
  }
}

// Turned, the angle looks to a muscle like a negative a, which no braid has: that was found to one per cent.
TEST(JointPamLog, ATurnedAngleIsNamed) {
  for (const bool both : {true, false}) {
    CsvTable table = CsvTable::parse(jointLog(0.1, both), "joint.csv");
    std::string text = "angle_rad,muscle_torque_Nm,pressure_flexor_Pa,pressure_extensor_Pa\n";
    const PamLog log = readJointPamLog(std::move(table), kPulley);
    for (std::size_t i = 0; i < log.rows(); ++i) {
      text +=
          fmt::format("{},{},{},{}\n", -(log.contraction[i] - kPulley.rest_flexor) * kPulley.length / kPulley.radius,
                      log.force[i] * kPulley.radius, log.pressure[i], log.opposing_pressure[i]);
    }
    EXPECT_THAT(errorOf([&] { fitPam(readJoint(text), {}); }), HasSubstr("angle_rad has the opposite sign")) << both;
  }
}

TEST(JointPamLog, ExchangedPressuresAreNamed) {
  std::string text = replaced(jointLog(0.1, true), "pressure_extensor_Pa", "pressure_other_Pa");
  text =
      replaced(replaced(text, "pressure_flexor_Pa", "pressure_extensor_Pa"), "pressure_other_Pa", "pressure_flexor_Pa");
  EXPECT_THAT(errorOf([&] { fitPam(readJoint(text), {}); }), HasSubstr("or exchange the pressures"));
}

TEST(JointPamLog, OneMuscleIsFoundFromItsTorque) {
  std::string text = jointLog(0.0, false);
  text = replaced(text, "pressure_extensor_Pa", "unused_Pa");
  const PamLog log = readJoint(text);
  ASSERT_FALSE(log.opposed());
  expectRig(fitPam(log, {}), 5e-3);
}

TEST(JointPamLog, ATendonIsPreferredWhereThereIsOne) {
  const PamComparison comparison = comparePam(readJoint(jointLog(0.1, true)), {}, std::nullopt, {}, std::nullopt);
  ASSERT_EQ(comparison.candidates.size(), 2U);
  EXPECT_EQ(comparison.chosen().name, "spring");
  EXPECT_NEAR(std::sqrt(comparison.chosen().fit.mse), 0.1 / kPulley.radius, 0.2);  // the noise, as a force
  EXPECT_GT(comparison.candidates[0].judgedError(), 2.0 * comparison.candidates[1].judgedError());
}

TEST(JointPamLog, ReadsAnExtensorAlone) {
  const PamLog log = readJoint("time_s,angle_deg,torque_Nm,pressure_extensor_bar\n0,0,-4,1\n1,10,-2,2\n");
  EXPECT_DOUBLE_EQ(log.force[0], 100.0);
  EXPECT_DOUBLE_EQ(log.pressure[1], 2e5);
  EXPECT_NEAR(log.contraction[1], 0.12 - 0.16 * std::numbers::pi / 18.0, 1e-12);
}

TEST(JointPamLog, SaysWhatIsMissing) {
  EXPECT_THAT(errorOf([&] { readJoint("angle_rad,torque_Nm\n0,1\n"); }),
              HasSubstr("joint.csv:1: found neither pressure_flexor_Pa nor pressure_extensor_Pa"));
  EXPECT_THAT(errorOf([&] { readJoint("torque_Nm,pressure_flexor_Pa\n0,1\n"); }), HasSubstr("angle_rad"));
  EXPECT_THAT(errorOf([&] { readJoint("angle_rad,torque_Nm,pressure_flexor_bar\n0,1,2\n0,x,2\n"); }),
              HasSubstr("joint.csv:3"));
}

}  // namespace
}  // namespace simgap::test
