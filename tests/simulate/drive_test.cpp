// Steady states worked out on paper from 000 eq. (8)-(11); motion against a fine integration of the same equations.
#include "simgap/simulate/drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/arms.h"

namespace simgap {
namespace {

constexpr double kDriveStep = 0.002;

const Motor kMotor = test::torso().motor_defaults;
const Gearbox kGearbox = test::torso().gearbox_defaults;
constexpr double kSpindleRadius = 0.006;

Motor withoutLosses() {
  Motor motor = kMotor;
  motor.viscous_friction = motor.coulomb_friction = 0.0;
  return motor;
}

Gearbox gearboxWithoutLosses() {
  Gearbox gearbox = kGearbox;
  gearbox.viscous_friction = gearbox.coulomb_friction = 0.0;
  return gearbox;
}

DriveState after(const Drive& drive, DriveState state, double voltage, double load, int steps) {
  for (int i = 0; i < steps; ++i) drive.step(state, voltage, load);
  return state;
}

// The slowest time constant of the drive is J / (b + N eta K_T K_E / R) = 13 ms: 2 s is 150 of them.
DriveState steady(const Motor& motor, const Gearbox& gearbox, double voltage, double load) {
  return after(Drive(motor, gearbox, kDriveStep), {}, voltage, load, 1000);
}

// Right side minus left side of eq. (11), with the motor's torque from eq. (9): 0 for the true acceleration.
double torqueLeft(const Motor& m, const Gearbox& g, const DriveState& x, double load, double acceleration) {
  const double sign = x.motor_velocity > 0.0 ? 1.0 : -1.0;
  const double motor_torque = m.torque_constant * x.current - m.inertia * acceleration -
                              m.viscous_friction * x.motor_velocity - m.coulomb_friction * sign;
  return g.ratio * g.efficiency * motor_torque - g.coulomb_friction * sign -
         g.viscous_friction * x.motor_velocity / g.ratio - g.inertia * acceleration / g.ratio - load;
}

// Eq. (8) and (10) as they stand; (9) and (11) are linear in the acceleration, so two tries of it tell where they meet.
DriveState rate(const Motor& m, const Gearbox& g, const DriveState& x, double voltage, double load) {
  constexpr double kTrial = 1e4;  // J times it is of the order of the torques, so that no digits cancel
  const double none = torqueLeft(m, g, x, load, 0.0);
  const double trial = torqueLeft(m, g, x, load, kTrial);
  return {(voltage - m.resistance * x.current - m.back_emf_constant * x.motor_velocity) / m.inductance,
          kTrial * none / (none - trial), x.motor_velocity / g.ratio};
}

DriveState along(const DriveState& x, const DriveState& rate, double dt) {
  return {x.current + dt * rate.current, x.motor_velocity + dt * rate.motor_velocity,
          x.shaft_angle + dt * rate.shaft_angle};
}

DriveState rungeKutta(const Motor& m, const Gearbox& g, DriveState x, double voltage, double load, double duration) {
  const int steps = static_cast<int>(std::lround(duration / 5e-7));
  const double dt = duration / steps;
  for (int i = 0; i < steps; ++i) {
    const DriveState a = rate(m, g, x, voltage, load);
    const DriveState b = rate(m, g, along(x, a, dt / 2), voltage, load);
    const DriveState c = rate(m, g, along(x, b, dt / 2), voltage, load);
    const DriveState d = rate(m, g, along(x, c, dt), voltage, load);
    x = along(along(along(along(x, a, dt / 6), b, dt / 3), c, dt / 3), d, dt / 6);
  }
  return x;
}

void expectSame(const DriveState& found, const DriveState& expected, double tolerance) {
  EXPECT_NEAR(found.current, expected.current, tolerance * (1.0 + std::abs(expected.current)));
  EXPECT_NEAR(found.motor_velocity, expected.motor_velocity, tolerance * (1.0 + std::abs(expected.motor_velocity)));
  EXPECT_NEAR(found.shaft_angle, expected.shaft_angle, tolerance * (1.0 + std::abs(expected.shaft_angle)));
}

TEST(Drive, StallCurrentIsVoltageOverResistance) {
  // A load of just what the stalled motor delivers: N eta K_T V / R less the Coulomb torque N eta tau_CM + tau_CG.
  const double stall = 72.0 * 0.72 * 0.011 * 12.0 / 0.8 - (72.0 * 0.72 * 0.002 + 0.03);
  EXPECT_NEAR(stall, 8.4, 0.05);
  const DriveState held = steady(kMotor, kGearbox, 12.0, stall * (1.0 + 1e-6));
  EXPECT_NEAR(held.current, 12.0 / 0.8, 1e-12);
  EXPECT_LE(held.shaft_angle, 0.0) << "sank until the current had built up";
  EXPECT_EQ(held.motor_velocity, 0.0);
  EXPECT_GT(steady(kMotor, kGearbox, 12.0, stall * (1.0 - 1e-3)).motor_velocity, 0.0);
}

TEST(Drive, NoLoadSpeedWithoutLossesIsVoltageOverBackEmfConstant) {
  const DriveState running = steady(withoutLosses(), gearboxWithoutLosses(), 12.0, 0.0);
  EXPECT_NEAR(running.motor_velocity, 12.0 / 0.011, 1e-9);
  EXPECT_NEAR(running.current, 0.0, 1e-12);
}

TEST(Drive, NoLoadSpeedWithLossesBalancesTorqueAndVoltage) {
  // V = R i + K_E w and N eta (K_T i - mu_M w - tau_CM) = tau_CG + mu_G w / N, solved for w.
  const double gain = 72.0 * 0.72;
  const double drive = gain * 0.011 * 12.0 / 0.8 - gain * 0.002 - 0.03;
  const double brake = gain * 0.011 * 0.011 / 0.8 + gain * 1e-6 + 0.002 / 72.0;
  const DriveState running = steady(kMotor, kGearbox, 12.0, 0.0);
  EXPECT_NEAR(running.motor_velocity, drive / brake, 1e-9);
  EXPECT_NEAR(running.motor_velocity / 72.0, 14.8, 0.05);
  EXPECT_NEAR(running.current, (12.0 - 0.011 * drive / brake) / 0.8, 1e-11);
}

TEST(Drive, TorquesBalanceAtConstantSpeed) {
  for (const double load : {-2.0, -0.1, 0.0, 0.5, 3.0, 7.0}) {
    const DriveState x = steady(kMotor, kGearbox, 12.0, load);
    ASSERT_GT(x.motor_velocity, 0.0);
    // Terms are up to 8 N m, the steady state is reached to rounding: a few 1e-15 of them remain.
    EXPECT_NEAR(torqueLeft(kMotor, kGearbox, x, load, 0.0), 0.0, 1e-12) << "load " << load;
    EXPECT_NEAR(12.0, 0.8 * x.current + 0.011 * x.motor_velocity, 1e-12);
  }
}

TEST(Drive, LosslessGearboxKeepsPower) {
  // eta = 1, no friction: K_T i w = T w / N, electrical power less heat is mechanical power at the spindle.
  Gearbox gearbox = gearboxWithoutLosses();
  gearbox.efficiency = 1.0;
  const DriveState x = steady(withoutLosses(), gearbox, 12.0, 5.0);
  const double mechanical = 5.0 * x.motor_velocity / 72.0;
  EXPECT_NEAR(12.0 * x.current - 0.8 * x.current * x.current, mechanical, 1e-10 * mechanical);
}

TEST(Drive, OneStepIsAsExactAsTwoThousand) {
  const Drive coarse(kMotor, kGearbox, kDriveStep);
  const Drive fine(kMotor, kGearbox, kDriveStep / 2000);
  for (const double velocity : {300.0, -300.0}) {
    for (const double voltage : {12.0, 0.0}) {
      const DriveState start{1.0, velocity, 0.5};
      DriveState one = start;
      coarse.step(one, std::copysign(voltage, velocity), 0.4);
      // Rounding of 2000 products, 1e-16 each.
      expectSame(one, after(fine, start, std::copysign(voltage, velocity), 0.4, 2000), 1e-11);
    }
  }
}

TEST(Drive, StepSolvesTheEquationsOfMotorAndGearbox) {
  const Drive drive(kMotor, kGearbox, kDriveStep);
  const DriveState start{-2.0, 150.0, -1.0};
  for (const double voltage : {-1.0, 4.0, 12.0}) {
    // Runge & Kutta's error is (0.5 us / 0.375 ms)^5 / 120 per step of what changes: 1e-12 in all.
    expectSame(after(drive, start, voltage, 1.0, 3), rungeKutta(kMotor, kGearbox, start, voltage, 1.0, 3 * kDriveStep),
               1e-11);
  }
}

TEST(Drive, IsTheSameInBothDirections) {
  const Drive drive(kMotor, kGearbox, kDriveStep);
  DriveState forward{1.5, 20.0, 0.1};
  DriveState backward{-1.5, -20.0, -0.1};
  for (int i = 0; i < 200; ++i) {
    const double voltage = 3.0 * std::sin(0.1 * i);
    drive.step(forward, voltage, 0.3);
    drive.step(backward, -voltage, -0.3);
    ASSERT_EQ(forward.shaft_angle, -backward.shaft_angle);
    ASSERT_EQ(forward.motor_velocity, -backward.motor_velocity);
    ASSERT_EQ(forward.current, -backward.current);
  }
}

TEST(Drive, HoldsExactlyWithinTheCoulombTorqueAndSlipsBeyond) {
  // Both Coulomb torques at the spindle: 72 * 0.72 * 2 mN m + 30 mN m; with a 6 mm spindle about 22 N of line force.
  const double coulomb = 72.0 * 0.72 * 0.002 + 0.03;
  EXPECT_NEAR(coulomb / kSpindleRadius, 22.3, 0.1);
  for (const double sign : {1.0, -1.0}) {
    const DriveState held = steady(kMotor, kGearbox, 0.0, sign * coulomb * (1.0 - 1e-9));
    EXPECT_EQ(held.shaft_angle, 0.0);
    EXPECT_EQ(held.motor_velocity, 0.0);
    EXPECT_LT(sign * steady(kMotor, kGearbox, 0.0, sign * coulomb * (1.0 + 1e-9)).motor_velocity, 0.0);
  }
}

TEST(Drive, MotorTorqueCountsTowardsTheCoulombLimit) {
  const double coulomb = 72.0 * 0.72 * 0.002 + 0.03;
  const double volts_per_torque = 0.8 / (72.0 * 0.72 * 0.011);
  EXPECT_EQ(steady(kMotor, kGearbox, coulomb * (1.0 - 1e-9) * volts_per_torque, 0.0).shaft_angle, 0.0);
  EXPECT_GT(steady(kMotor, kGearbox, coulomb * (1.0 + 1e-6) * volts_per_torque, 0.0).motor_velocity, 0.0);
  // A load in its favour moves the window by itself: 1 N m is held between 1 - coulomb and 1 + coulomb.
  const Drive drive(kMotor, kGearbox, kDriveStep);
  const auto motionFrom = [&](double torque) {
    const double voltage = torque * volts_per_torque;
    return after(drive, {voltage / 0.8, 0.0, 0.0}, voltage, 1.0, 50).shaft_angle;
  };
  EXPECT_EQ(motionFrom(1.0 - 0.999 * coulomb), 0.0);
  EXPECT_EQ(motionFrom(1.0 + 0.999 * coulomb), 0.0);
  EXPECT_LT(motionFrom(1.0 - 1.001 * coulomb), 0.0);
  EXPECT_GT(motionFrom(1.0 + 1.001 * coulomb), 0.0);
}

TEST(Drive, CurrentOfAStandingMotorRisesExponentially) {
  const double coulomb_voltage = 0.1;  // 72 * 0.72 * 0.011 * 0.125 A = 0.071 N m: below the limit
  const DriveState x = after(Drive(kMotor, kGearbox, kDriveStep / 10), {}, coulomb_voltage, 0.0, 3);
  EXPECT_NEAR(x.current, 0.125 * (1.0 - std::exp(-0.8 * 0.0006 / 0.0003)), 1e-15);
}

TEST(Drive, StopsWithinAStepAndStays) {
  const Drive drive(kMotor, kGearbox, kDriveStep);
  const Drive fine(kMotor, kGearbox, kDriveStep / 1000);
  DriveState state{0.0, 5.0, 0.0};
  int steps = 0;
  for (; state.motor_velocity != 0.0 && steps < 100; ++steps) {
    const DriveState before = state;
    drive.step(state, 0.0, 0.05);
    ASSERT_GE(state.motor_velocity, 0.0) << "beyond the stop";
    ASSERT_GE(state.shaft_angle, before.shaft_angle);
  }
  EXPECT_LT(steps, 100);
  // Within the step of the stop constant deceleration is taken; w dt / (8 N) is what that can be wrong by.
  EXPECT_NEAR(state.shaft_angle, after(fine, {0.0, 5.0, 0.0}, 0.0, 0.05, 1000 * steps).shaft_angle,
              5.0 * kDriveStep / (8.0 * 72.0));
  const double stopped = state.shaft_angle;
  EXPECT_EQ(after(drive, state, 0.0, 0.05, 1000).shaft_angle, stopped);
}

TEST(Drive, StopWithinAStepTakesTheWayOfConstantDeceleration) {
  // From 1 rad/s at (T + c) / J = 1770 rad/s^2: stops after a quarter of the step, w^2 / (2 a N) further.
  const double inertia = 72.0 * 0.72 * 2e-6 + 1e-5 / 72.0;
  const double deceleration = (0.05 + 72.0 * 0.72 * 0.002 + 0.03) / inertia;
  const DriveState x = after(Drive(kMotor, kGearbox, kDriveStep), {0.0, 1.0, 0.0}, 0.0, 0.05, 1);
  EXPECT_EQ(x.motor_velocity, 0.0);
  const double way = 1.0 / (2.0 * deceleration * 72.0);
  EXPECT_NEAR(x.shaft_angle, way, 0.1 * way) << "the generator's torque, left out on paper, is some percent";
}

TEST(Drive, TurnsBackAfterAStopWhenTheLoadWins) {
  const DriveState x = after(Drive(kMotor, kGearbox, kDriveStep), {0.0, 50.0, 0.0}, 0.0, 2.0, 1000);
  EXPECT_LT(x.motor_velocity, 0.0);
}

TEST(Drive, LoadDrivesItBackAgainstFrictionAndGeneratorTorque) {
  // Shorted (V = 0): T = c + (b + N eta K_T K_E / R) |w|, eta multiplying as printed in eq. (11).
  const double gain = 72.0 * 0.72;
  const double brake = gain * 0.011 * 0.011 / 0.8 + gain * 1e-6 + 0.002 / 72.0;
  const DriveState x = steady(kMotor, kGearbox, 0.0, 1.0);
  EXPECT_NEAR(x.motor_velocity, -(1.0 - gain * 0.002 - 0.03) / brake, 1e-9);
  EXPECT_NEAR(x.current, 0.011 * (1.0 - gain * 0.002 - 0.03) / brake / 0.8, 1e-11) << "generates";
  EXPECT_LT(x.shaft_angle, 0.0) << "the line unwinds";
}

TEST(Drive, WithoutCoulombFrictionTheSmallestLoadTurnsIt) {
  EXPECT_LT(steady(withoutLosses(), gearboxWithoutLosses(), 0.0, 1e-9).motor_velocity, 0.0);
}

/// The largest difference of motor velocities while a square wave turns the rotor again and again, looked at 1 ms.
double errorOverTurns(double step) {
  constexpr double kLook = 1e-3;
  const Drive drive(kMotor, kGearbox, step);
  DriveState coarse, fine;
  double error = 0.0;
  for (int look = 0; look < 240; ++look) {
    const double voltage = look / 40 % 2 == 0 ? 6.0 : -4.0;
    for (long i = std::lround(kLook / step); i-- > 0;) drive.stepThrough(coarse, voltage, 0.0);
    fine = rungeKutta(kMotor, kGearbox, fine, voltage, 0.0, kLook);
    error = std::max(error, std::abs(coarse.motor_velocity - fine.motor_velocity));
  }
  return error;
}

// A rotor that stood for the rest of the step in which it turned was 0.5 % late, in proportion to the step.
TEST(Drive, TurnsAsOftenAsItWillWithAnErrorOfSecondOrder) {
  const double error = errorOverTurns(1e-3), half = errorOverTurns(5e-4);
  EXPECT_LT(error, 2.0);  // [rad/s] of some 900
  EXPECT_LT(half, error / 2.5);
}

}  // namespace
}  // namespace simgap
