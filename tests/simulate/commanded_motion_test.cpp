// Pneumatic muscles, a motor and a servo at a joint in motion, against the equation of one hinge written anew and
// integrated by Runge-Kutta.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/motion_schedule.h"
#include "simgap/simulate/rollout.h"
#include "simgap/simulate/served_arm.h"
#include "simgap/simulate/simulation.h"
#include "support/files.h"

namespace simgap {
namespace {

using testing::HasSubstr;

constexpr const char* kForearm = R"(
format: simgap/arm/2
name: forearm
gravity_m_s2: [0, 0, -9.81]
bodies:
  - {name: base, fixed: true}
  - name: link
    parts: [{name: ball, shape: sphere, radius_m: 0.03, mass_kg: 0.8, position_m: [0, 0, -0.2]}]
joints:
  - {name: elbow, type: revolute, parent: base, child: link, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0],
     axis: [1, 0, 0], lower_limit_rad: -3, upper_limit_rad: 3, coulomb_friction_Nm: 0, viscous_friction_Nms: 0.05}
muscles: []
tendons:
  - {name: front, kind: pneumatic-muscle, attachments: [{body: base, point_m: [0, 0.03, 0.23]}, {body: link, point_m: [0, 0.03, -0.01]}],
     a_m2: 0.008, b_m2: -0.006, c_m2: 0.001, k_N: 4000, muscle_length_m: 0.2, rest_length_m: 0.245, damping_Ns_m: 60,
     fill_time_s: 0.08}
  - {name: back, kind: pneumatic-muscle, attachments: [{body: base, point_m: [0, -0.03, 0.23]}, {body: link, point_m: [0, -0.03, -0.01]}],
     a_m2: 0.008, b_m2: -0.006, c_m2: 0.001, k_N: 4000, muscle_length_m: 0.2, rest_length_m: 0.25, damping_Ns_m: 60}
  - {name: drive, kind: joint-motor, joint: elbow, torque_constant_Nm_A: 0.03, ratio: 60, efficiency: 0.7, viscous_friction_Nms: 0.04}
  - {name: hold, kind: joint-servo, joint: elbow, stiffness_Nm_rad: 1.5, offset_rad: 0.02, damping_Nms: 0.03}
)";

constexpr std::array<double, 4> kTimes = {0.0, 0.2, 0.5, 0.8};
constexpr double kPressures[2][4] = {{1.5e5, 3e5, 0.5e5, 1e5}, {1.5e5, 1e5, 1e5, 3e5}};
constexpr std::array<double, 4> kCurrents = {0.0, 1.2, -0.8, 0.4}, kTargets = {0.1, 0.1, 0.6, -0.3};

/// The hinge by hand.
struct Hinge {
  /// Force of a muscle by bisection of 002 eq. 16.
  static double muscleForce(double rest, double pressure, double length, double rate) {
    const auto area = [](double x) { return 0.008 * x * x - 0.006 * x + 0.001; };
    const double end = (0.006 - std::sqrt(0.006 * 0.006 - 4 * 0.008 * 0.001)) / (2 * 0.008);
    const double eps = (rest - length) / 0.2;
    if (eps >= end || pressure <= 0.0) return 0.0;
    double low = 0.0, high = 4000.0 * (end - eps);
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (pressure * area(eps + middle / 4000.0) > middle ? low : high) = middle;
    }
    return std::max(0.0, low + 60.0 * rate);
  }

  std::array<double, 3> slope(const std::array<double, 3>& s, std::size_t row) const {
    const auto [q, w, p] = s;
    double torque = -0.8 * 9.81 * 0.2 * std::sin(q) - 0.05 * w;
    for (int side : {0, 1}) {
      const double y0 = side == 0 ? 0.03 : -0.03, z0 = 0.23, z1 = -0.01;
      // The point (y0, z1) of the link, turned about x.
      const double y = y0 * std::cos(q) - z1 * std::sin(q), z = y0 * std::sin(q) + z1 * std::cos(q);
      const double length = std::hypot(y - y0, z - z0);
      const double lever = ((y - y0) * -z + (z - z0) * y) / length;  // dL/dq
      torque -= lever * muscleForce(side == 0 ? 0.245 : 0.25, side == 0 ? p : kPressures[1][row], length, lever * w);
    }
    torque += 0.03 * 60 * 0.7 * kCurrents[row] - 0.04 * w;
    torque += 1.5 * (kTargets[row] + 0.02 - q) - 0.03 * w;
    const double inertia = 0.8 * 0.2 * 0.2 + 0.4 * 0.8 * 0.03 * 0.03;
    return {w, torque / inertia, (kPressures[0][row] - p) / 0.08};
  }

  /// Angles at multiples of 0.05 s.
  std::vector<double> play(double start, double end) const {
    constexpr double h = 5e-5;
    std::array<double, 3> s = {start, 0.0, kPressures[0][0]};
    std::vector<double> angles{start};
    const long steps = std::lround(end / h), every = std::lround(0.05 / h);
    for (long i = 0; i < steps; ++i) {
      std::size_t row = 0;
      while (row + 1 < kTimes.size() && kTimes[row + 1] <= static_cast<double>(i) * h + 1e-9) ++row;
      const auto moved = [&](const std::array<double, 3>& by, double part) {
        return std::array{s[0] + part * by[0], s[1] + part * by[1], s[2] + part * by[2]};
      };
      const auto k1 = slope(s, row), k2 = slope(moved(k1, 0.5 * h), row), k3 = slope(moved(k2, 0.5 * h), row),
                 k4 = slope(moved(k3, h), row);
      for (std::size_t c = 0; c < 3; ++c) s[c] += h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]);
      if ((i + 1) % every == 0) angles.push_back(s[0]);
    }
    return angles;
  }
};

ArmModel forearmOfMuscles() { return readArm(YamlNode::parse(kForearm, "forearm.yaml")); }

MotionCommands stepsOfAllFour() {
  MotionCommands commands;
  commands.times.assign(kTimes.begin(), kTimes.end());
  commands.values.resize(4, 4);
  for (Eigen::Index row = 0; row < 4; ++row) {
    const auto r = static_cast<std::size_t>(row);
    commands.values.col(row) << kPressures[0][r], kPressures[1][r], kCurrents[r], kTargets[r];
  }
  return commands;
}

double largestError(double step, const std::vector<double>& truth) {
  RolloutOptions options;
  options.step = step;
  Rollout rollout(forearmOfMuscles(), options);
  std::vector<double> times;
  for (std::size_t i = 0; i < truth.size(); ++i) times.push_back(0.05 * static_cast<double>(i));
  MotionStart start;
  start.joints.resize(1);
  start.joints[0].angle = truth.front();
  MotionTrack track;
  EXPECT_TRUE(rollout.run(stepsOfAllFour(), start, times, track).finished);
  double error = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) error = std::max(error, std::abs(track.joints[i].angle - truth[i]));
  return error;
}

TEST(CommandedMotion, FollowsTheEquationOfAHingeToSecondOrder) {
  const std::vector<double> truth = Hinge().play(0.3, 1.2);
  const auto [lowest, highest] = std::ranges::minmax(truth);
  EXPECT_GT(highest - lowest, 0.5) << "it moves";
  const double coarse = largestError(0.001, truth), fine = largestError(0.0005, truth);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_GT(coarse / fine, 2.0);
}

TEST(CommandedMotion, WithoutFillTimePressureActsAtOnce) {
  ArmModel model = forearmOfMuscles();
  const auto pressureAfter = [&](double fill_time) {
    model.tendons[0].p[7] = fill_time;
    Rollout rollout(model, {});
    MotionTrack track;
    rollout.run(stepsOfAllFour(), {}, std::vector{0.2, 0.24}, track);
    EXPECT_NEAR(track.line_commands(0, 0), 1.5e5, 1e-6) << "the first command has been followed when it begins";
    return track.line_commands(0, 1);
  };
  EXPECT_NEAR(pressureAfter(0.08), 3e5 - 1.5e5 * std::exp(-0.5), 1.0);
  EXPECT_NEAR(pressureAfter(0.0), 3e5, 1e-6);
}

TEST(CommandedMotion, SchedulesCommandLinesInTheirUnits) {
  const ArmModel model = forearmOfMuscles();
  const auto read = [&](const std::string& front) {
    const std::string text = R"(
format: simgap/schedule/1
duration_s: 1
tendons:
  front: {segments: [)" + front +
                             R"(]}
  back: {segments: [{hold_Pa: 1.0e5}]}
  drive: {segments: [{hold_A: 0}, {at_s: 0.5, sine_A: 0.5, frequency_Hz: 1, for_s: 0.5}]}
  hold: {segments: [{hold_rad: 0.2}]}
)";
    return readSchedule(YamlNode::parse(text, "s.yaml"), model, 500.0, {});
  };
  const MotionCommands commands = read("{hold_bar: 1.0}, {at_s: 0.2, ramp_Pa: 3.0e5, for_s: 0.2}");
  std::vector<double> values(4);
  std::size_t row = 0;
  commands.at(0.3, row, values);
  EXPECT_THAT(values, testing::Pointwise(testing::DoubleNear(1e-6), {2e5, 1e5, 0.0, 0.2}));
  EXPECT_THAT(test::errorOf([&] { read("{hold_Pa: -5}"); }), HasSubstr("pressure_front: -5 Pa, expected >= 0"));
  EXPECT_THAT(test::errorOf([&] { read("{sine_Pa: 5, frequency_kHz: 0.3, for_s: 1}"); }),
              HasSubstr("frequency: found 300 Hz, expected at most 250: commands change 500 times a second"));
}

TEST(CommandedMotion, TablesCommandLinesAndNameWhatIsMissing) {
  const ArmModel model = forearmOfMuscles();
  const auto read = [&](const std::string& text) {
    return readCommands(CsvTable::parse(text, "c.csv"), model, /*linear=*/false);
  };
  const MotionCommands commands = read(
      "time_s,pressure_front_bar,pressure_back_Pa,current_drive_A,target_hold_deg\n"
      "0,2,1e5,0.5,90\n");
  EXPECT_NEAR(commands.values(0, 0), 2e5, 1e-6);
  EXPECT_NEAR(commands.values(3, 0), 1.5707963, 1e-6);
  EXPECT_THAT(test::errorOf([&] { read("time_s,pressure_front_bar,current_drive_A,target_hold_deg\n0,2,0.5,90\n"); }),
              HasSubstr("pressure_back"));
}

TEST(CommandedMotion, AServedArmTakesThemAndTellsTheirForces) {
  ServedArm arm(forearmOfMuscles(), {});
  const std::string answer =
      arm.answer(R"({"commands":{"front":{"pressure_Pa":2e5},"hold":{"target_rad":0.3}},"advance_s":0.5})");
  const Json state = Json::parse(answer);
  EXPECT_GT(state.at("tension_N").at("front").get<double>(), 1.0);
  EXPECT_EQ(state.at("tension_N").at("back").get<double>(), 0.0);
  EXPECT_TRUE(state.at("torque_Nm").contains("hold"));
  EXPECT_THAT(arm.answer(R"({"commands":{"front":{"setpoint_rad":1}}})"), HasSubstr("front: expected pressure_Pa"));
  EXPECT_THAT(arm.answer(R"({"commands":{"front":{"pressure_Pa":-1}}})"), HasSubstr("expected >= 0"));
}

TEST(CommandedMotion, BeginsAtRestUnderTheFirstCommands) {
  const ArmModel model = forearmOfMuscles();
  const MotionCommands commands = stepsOfAllFour();
  const MotionStart start = restUnder(model, commands, 0.0, 0.0);
  ASSERT_EQ(start.joints.size(), 1U);
  Rollout rollout(model, {});
  MotionTrack track;
  ASSERT_TRUE(rollout.run(commands, start, std::vector{0.0, 0.19}, track).finished);
  EXPECT_NEAR(track.joints[1].angle, track.joints[0].angle, 1e-6);
  EXPECT_LT(track.joint_velocities[1].norm(), 1e-5);
}

}  // namespace
}  // namespace simgap
