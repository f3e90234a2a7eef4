// A drive with a cable: its steps against closed forms and against a rig of bristles that shares no code with it, its
// trapezoids, and what compensation does to both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <vector>

#include "reality/cable_rig.h"
#include "simgap/core/error.h"
#include "simgap/core/rotation.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/model/actuator/friction_drive.h"
#include "simgap/simulate/cable_drive_study.h"
#include "support/files.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

FittedModel modelFile(const std::string& file) {
  return readFittedModel(YamlNode::load(sourceFile("data/cable-drive/" + file)));
}
CableDrive sampleDrive() {
  return readCableDrive(YamlNode::load(sourceFile("data/cable-drive/drive.yaml")), modelFile);
}
CableDriveCommands samplePath(const CableDrive& drive) {
  return readCableDriveSchedule(YamlNode::load(sourceFile("data/cable-drive/path.yaml")), drive.rate);
}

/// No friction, no weight, no damping.
CableDrive bareDrive() {
  CableDrive drive = sampleDrive();
  drive.drive = {{}, 1.3, 0.0};
  drive.weight = drive.damping = drive.viscous_friction = 0.0;
  return drive;
}

TEST(Trapezoid, ArrivesWhenVelocityAndAccelerationLetIt) {
  constexpr double kTick = 1e-3;
  // 1 rad: at 1 rad/s with ramps of 0.2 s, or, never that fast, all ramp.
  for (const auto& [velocity, seconds] : {std::pair{1.0, 1.0 / 1.0 + 1.0 / 5.0}, {10.0, 2.0 * std::sqrt(1.0 / 5.0)}}) {
    Trapezoid trapezoid(velocity, 5.0);
    double before = 0.0, arrived = 0.0;
    for (int i = 1; arrived == 0.0 && i < 3000; ++i) {
      trapezoid.update(1.0, kTick);
      EXPECT_LE(trapezoid.velocity(), velocity + 1e-12);
      EXPECT_LE(std::abs(trapezoid.velocity() - before), 5.0 * kTick * (1.0 + 1e-9));
      EXPECT_LE(trapezoid.position(), 1.0);
      before = trapezoid.velocity();
      if (trapezoid.position() == 1.0) arrived = i * kTick;
    }
    EXPECT_NEAR(arrived, seconds, 3.0 * kTick);
  }
}

TEST(Trapezoid, TurnsRoundForAnotherGoalWithoutAJump) {
  Trapezoid trapezoid(1.0, 5.0);
  double before = 0.0;
  for (int i = 0; i < 3000; ++i) {
    trapezoid.update(i < 400 ? 1.0 : -0.3, 1e-3);
    EXPECT_LE(std::abs(trapezoid.velocity() - before), 5e-3 * (1.0 + 1e-9));
    before = trapezoid.velocity();
  }
  EXPECT_EQ(trapezoid.position(), -0.3);
  EXPECT_EQ(trapezoid.velocity(), 0.0);
}

/// Two inertias on a spring under a constant torque on one of them: the spring's torque is
/// T J_M N^2 / (J + J_M N^2) (1 - cos w t), w^2 = K (1 / J + 1 / (J_M N^2)).
TEST(CableDriveMotion, SwingsAsTwoInertiasOnASpring) {
  const CableDrive drive = bareDrive();
  const double motor = drive.motor_inertia * std::pow(drive.control.ratio, 2);
  const double w = std::sqrt(drive.stiffness * (1.0 / drive.inertia + 1.0 / motor));
  CableDriveMotion motion(drive);
  motion.reset(0.0);
  constexpr double kStep = 1e-6;
  for (int i = 1; i <= 200000; ++i) {
    motion.step(0.0, 7.0, kStep);
    if (i % 10000 != 0) continue;
    const double expected = -7.0 * motor / (drive.inertia + motor) * (1.0 - std::cos(w * i * kStep));
    EXPECT_NEAR(motion.cableTorque(), expected, 2e-3) << i;  // steps of first order
  }
}

TEST(CableDriveMotion, RestsExactlyUntilItBreaksAway) {
  CableDrive drive = bareDrive();
  drive.drive.friction = {.n_c1 = 0.2, .n_c2 = 1.0, .n_s1 = 0.4, .n_s2 = 2.0, .k_v = 0.01, .v_s = 5.0, .delta = 1.0};
  drive.weight = 10.0;
  const auto moves = [&](double torque, double joint) {
    CableDriveMotion motion(drive);
    motion.reset(joint);
    const double before = motion.motor();
    for (int i = 0; i < 2000; ++i) motion.step(torque / drive.drive.k_a, 0.0, 1e-4);
    EXPECT_EQ(motion.motor() == before, motion.motorVelocity() == 0.0);
    return motion.motor() != before;
  };
  EXPECT_FALSE(moves(1.99, 0.0));
  EXPECT_TRUE(moves(2.01, 0.0));
  // Level, it carries 10 N m, and friction has 0.4 of them more.
  const double level = 0.5 * std::numbers::pi;
  EXPECT_FALSE(moves(10.0 + 5.99, level));
  EXPECT_TRUE(moves(10.0 + 6.01, level));
  EXPECT_FALSE(moves(10.0 - 5.99, level));
  EXPECT_TRUE(moves(10.0 - 6.01, level));
}

/// Dry friction alone stops a motor after w J_M N / tau_c, and then it stands.
TEST(CableDriveMotion, DryFrictionStopsTheMotorAfterItsTime) {
  CableDrive drive = bareDrive();
  drive.stiffness = 1e-9;
  drive.drive.friction = {.n_c2 = 2.0, .n_s2 = 2.0};
  CableDriveMotion motion(drive);
  motion.reset(0.0);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 10000; ++i) motion.step(10.0, 0.0, kStep);
  const double w = motion.motorVelocity();
  EXPECT_NEAR(w, 0.1 * (13.0 - 2.0) / (drive.motor_inertia * drive.control.ratio), 1e-6 * w);
  const double expected = w * drive.motor_inertia * drive.control.ratio / 2.0;
  double stopped = 0.0;
  for (int i = 1; stopped == 0.0 && i < 100000; ++i) {
    motion.step(0.0, 0.0, kStep);
    if (motion.motorVelocity() == 0.0) stopped = i * kStep;
  }
  EXPECT_NEAR(stopped, expected, 2.0 * kStep);
}

/// Drives that are led by one and the same controller.
class Led {
 public:
  Led(const CableDrive& drive, const FrictionCompensation& compensation, const MotionCommands& path)
      : drive_(drive),
        path_(path),
        trapezoid_(drive.velocity, drive.acceleration),
        observer_(drive.observer),
        controller_(drive.control, compensation.drive, compensation.share) {}

  double operator()(double time, double encoder) {
    if (reference.empty()) observer_.reset(encoder), trapezoid_.reset(path_.values(0, 0));
    observer_.update(encoder, 1.0 / drive_.rate);
    std::array<double, 2> told{};
    path_.at(std::floor(time * drive_.set_point_rate + 1e-9) / drive_.set_point_rate, row_, told);
    trapezoid_.update(told[0], 1.0 / drive_.rate);
    reference.push_back(trapezoid_.position());
    return controller_.follow(trapezoid_.position(), trapezoid_.velocity(), drive_.weightAt(trapezoid_.position()),
                              observer_.angle(), observer_.velocity(), 1.0 / drive_.rate);
  }
  std::vector<double> reference;

 private:
  const CableDrive& drive_;
  const MotionCommands& path_;
  Trapezoid trapezoid_;
  VelocityObserver observer_;
  TrajectoryController controller_;
  std::size_t row_ = 0;
};

/// The rig of those numbers, with friction of its own.
reality::CableRig rigOf(const CableDrive& drive, const reality::FrictionTruth& friction) {
  reality::CableRig rig;
  rig.friction = friction;
  rig.ratio = drive.control.ratio;
  rig.rotor = drive.motor_inertia;
  rig.stiffness = drive.stiffness, rig.damping = drive.damping;
  rig.inertia = drive.inertia, rig.weight = drive.weight, rig.air = drive.viscous_friction;
  rig.encoder_step = drive.counts > 0.0 ? 2.0 * std::numbers::pi / drive.counts : 0.0;
  return rig;
}

/// Slow and fast sinusoids, and a rest.
CableDriveCommands shortPath(const CableDrive& drive) {
  return readCableDriveSchedule(YamlNode::parse(R"(format: simgap/schedule/1
joint:
  position:
    segments:
      - {hold_deg: 20, for_s: 1}
      - {sine_deg: 40, frequency_Hz: 0.2, for_s: 10}
      - {sine_deg: 5, frequency_Hz: 0.25, for_s: 8}
      - {hold_deg: 20, for_s: 15}
)",
                                                "path.yaml"),
                                drive.rate);
}

/// Friction that does not fade, so that both mean the same: the set at rest against bristles, steps of first order
/// against Runge and Kutta's. Friction goes by the reference, whose sign both see alike.
TEST(CableDriveMotion, FollowsAsARigOfBristlesDoes) {
  CableDrive drive = sampleDrive();
  drive.drive = {{.n_c1 = 0.3, .n_c2 = 1.2, .n_s1 = 0.3, .n_s2 = 1.2, .k_v = 0.012}, 1.3, 0.0};
  drive.control.by_reference = true;
  reality::FrictionTruth friction;
  friction.sliding_per_load = friction.breakaway_per_load = 0.3;
  friction.sliding_offset = friction.breakaway_offset = 1.2;
  friction.bristle_travel = 0.005;
  const CableDriveCommands path = shortPath(drive);
  for (const double share : {0.0, 0.5}) {
    const FrictionCompensation part{"part", drive.drive, share};
    const DriveRun run = playCableDrive(drive, part, path, 12.0, {.settle = 0.0, .row_rate = 8000.0});
    Led led(drive, part, path.over_time);
    const reality::CableRigRecord record = reality::playCableRig(rigOf(drive, friction), path.over_time.values(0, 0),
                                                                 12.0, 1.0 / drive.rate, std::ref(led));
    ASSERT_EQ(record.joint.size(), run.track.joint.size());
    EXPECT_EQ(led.reference, run.track.reference);
    double squares = 0.0;
    for (std::size_t i = 0; i < record.joint.size(); ++i) {
      squares += std::pow(record.joint[i] - run.track.joint[i], 2) / static_cast<double>(record.joint.size());
    }
    // Bristles of 0.005 rad are 5e-5 rad of the joint; the difference falls with them (9e-5, 5e-5, 4e-5 for 0.01, 0.005
    // and 0.003 rad without compensation).
    EXPECT_LT(std::sqrt(squares), 1e-4) << "share " << share;
    EXPECT_GT(run.tracking.rms, 2e-3) << "there is something to agree on";
  }
}

/// RMS of joint - reference [rad], and how far the motor wanders in the last 8 s [rad of the joint].
struct RigTracking {
  double rms = 0.0, current = 0.0, wandering = 0.0;
};
RigTracking leadRig(const CableDrive& drive, const reality::CableRig& rig, const FrictionCompensation& compensation) {
  const CableDriveCommands path = shortPath(drive);
  Led led(drive, compensation, path.over_time);
  const double end = path.over_time.end();
  const reality::CableRigRecord record =
      reality::playCableRig(rig, path.over_time.values(0, 0), end, 1.0 / drive.rate, std::ref(led));
  RigTracking tracking;
  const auto n = static_cast<double>(record.joint.size());
  double low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < record.joint.size(); ++i) {
    tracking.rms += std::pow(record.joint[i] - led.reference[i], 2) / n;
    tracking.current += std::pow(record.current[i], 2) / n;
    if (record.time[i] < end - 8.0) continue;
    low = std::min(low, record.motor[i] / rig.ratio);
    high = std::max(high, record.motor[i] / rig.ratio);
  }
  return {std::sqrt(tracking.rms), std::sqrt(tracking.current), high - low};
}

/// Friction that is none of the laws: bristles, a static part that fades hyperbolically, a cable that hardens.
reality::FrictionTruth bristles() {
  reality::FrictionTruth friction;
  friction.sliding_offset = friction.breakaway_offset = 1.2;
  friction.bristle_travel = 0.02;
  friction.fades_hyperbolically = true;
  return friction;
}

reality::CableRig bristleRig(const CableDrive& drive) {
  reality::CableRig rig = rigOf(drive, bristles());
  rig.hardening = 2e5;
  return rig;
}

/// What fit-friction makes of such a drive's log.
DriveFeedForward fittedDrive(const char* law, std::uint64_t seed) {
  reality::FrictionTruth friction = bristles();
  friction.velocity_noise = 0.15, friction.load_noise = 0.03;
  const reality::LogDesign design{.rows = 10000, .sessions = 20, .heaviest = 28.0, .seed = seed};
  const FrictionLaw& found = friction::find(law);
  const FrictionFit fit = fitFriction(found, frictionData(reality::simulateFrictionLog(friction, design)), {});
  return feedForward(found, fit.uncertainty.estimates);
}

/// The offset of friction (variant A) helps a controller, too; that of static friction hardly (003 table 2).
TEST(FrictionCompensation, HelpsADriveThatIsNoneOfTheLaws) {
  const CableDrive drive = sampleDrive();
  const reality::CableRig rig = bristleRig(drive);
  const auto led = [&](const char* law) { return leadRig(drive, rig, {law, fittedDrive(law, 1), 0.7}).rms; };
  const double none = leadRig(drive, rig, {"none", drive.drive, 0.0}).rms;
  const double classic = led("classic"), variant_a = led("variant-a"), variant_b = led("variant-b");
  EXPECT_LT(classic, 0.65 * none);
  EXPECT_LT(variant_a, 0.95 * classic);
  EXPECT_NEAR(variant_b, variant_a, 0.05 * variant_a);
}

TEST(FrictionCompensation, TooMuchOfItHuntsWhereItsSignIsMeasured) {
  CableDrive drive = sampleDrive();
  const reality::CableRig rig = bristleRig(drive);
  const FrictionCompensation all{"", fittedDrive("variant-b", 1), 0.7}, much{"", all.drive, 1.3};
  EXPECT_LT(leadRig(drive, rig, all).wandering, 0.05 * kDegree);
  EXPECT_GT(leadRig(drive, rig, much).wandering, 0.15 * kDegree);
  drive.control.by_reference = true;
  EXPECT_LT(leadRig(drive, rig, much).wandering, 0.05 * kDegree);
  // The sample drive hunts likewise.
  drive = sampleDrive();
  const CableDriveStudy study = studyCableDrive(drive, samplePath(drive), 84.0, 1e-4, 100.0);
  EXPECT_EQ(study.step, 0.5 / drive.rate) << "the largest step of 0.1 ms that a tick of 0.125 ms is a multiple of";
  EXPECT_EQ(study.runs[0].name, "none");
  EXPECT_FALSE(study.runs[0].run.tracking.hunting.found());
  EXPECT_FALSE(study.runs[3].run.tracking.hunting.found()) << study.runs[3].name;
  EXPECT_TRUE(study.runs[4].run.tracking.hunting.found()) << study.runs[4].name;
  EXPECT_LT(study.runs[3].run.tracking.rms, 0.8 * study.runs[0].run.tracking.rms);
}

/// The table of docs/studies/drives.md.
TEST(SlowFrictionCompensation, ByLawAndShare) {
  constexpr int kLogs = 5;
  for (const bool by_reference : {false, true}) {
    CableDrive drive = sampleDrive();
    drive.control.by_reference = by_reference;
    const reality::CableRig rig = bristleRig(drive);
    const RigTracking none = leadRig(drive, rig, {"none", drive.drive, 0.0});
    std::printf("sign %s: none %.3f deg, %.2f A, wanders %.3f deg\n", by_reference ? "of the reference" : "measured",
                none.rms / kDegree, none.current, none.wandering / kDegree);
    for (const char* law : {"classic", "variant-a", "variant-b"}) {
      std::vector<DriveFeedForward> fits;
      for (int log = 1; log <= kLogs; ++log) fits.push_back(fittedDrive(law, static_cast<std::uint64_t>(log)));
      for (const double share : {0.5, 0.7, 0.9, 1.0, 1.1, 1.3}) {
        RigTracking mean;
        for (const DriveFeedForward& fit : fits) {
          const RigTracking one = leadRig(drive, rig, {law, fit, share});
          mean.rms += one.rms / kLogs;
          mean.current += one.current / kLogs;
          mean.wandering += one.wandering / kLogs;
        }
        std::printf("  %s, share %.1f: %.3f deg, %.2f A, wanders %.3f deg\n", law, share, mean.rms / kDegree,
                    mean.current, mean.wandering / kDegree);
        if (share <= 1.0) {
          EXPECT_LT(mean.rms, none.rms);
        }
      }
    }
  }
}

/// By hand: I = (3 + 0.5 ((0.2 3 + 1) + 0.01 20)) / 2 = 1.95 A; held direction, limit.
TEST(TrajectoryController, FeedsATorqueForwardByEquationThree) {
  const DriveFeedForward drive{{.n_c1 = 0.2, .n_c2 = 1.0, .n_s1 = 0.2, .n_s2 = 1.0, .k_v = 0.01}, 2.0, 0.0};
  TrajectoryController controller({.current_limit = 5.0, .dead_band = 0.5}, drive, 0.5);
  EXPECT_NEAR(controller.give(3.0, 0.0), 1.5, 1e-12) << "nothing has moved yet";
  EXPECT_NEAR(controller.give(3.0, 20.0), 1.95, 1e-12);
  EXPECT_NEAR(controller.give(3.0, -0.4), (3.0 + 0.5 * (1.6 - 0.004)) / 2.0, 1e-12);
  EXPECT_NEAR(controller.give(-3.0, -20.0), -1.95, 1e-12);
  EXPECT_EQ(controller.give(100.0, 20.0), 5.0);
}

/// A ramp of counts: the observer's velocity is the ramp's, and its angle is not late.
TEST(VelocityObserver, FollowsARampOfCounts) {
  constexpr double kTick = 1.25e-4, kCount = 2.0 * std::numbers::pi / 16384.0, kVelocity = 37.0;
  VelocityObserver observer(1000.0);
  for (int i = 0; i < 8000; ++i) observer.update(kCount * std::round(kVelocity * i * kTick / kCount), kTick);
  EXPECT_NEAR(observer.velocity(), kVelocity, 0.5);
  EXPECT_NEAR(observer.angle(), kVelocity * 7999 * kTick, 2.0 * kCount);
}

TEST(CableDriveFile, RefusesWithASentence) {
  const std::string file = readText(sourceFile("data/cable-drive/drive.yaml"));
  const auto sentence = [&](const char* from, const char* to, const auto& model) -> std::string {
    try {
      readCableDrive(YamlNode::parse(replaced(file, from, to), "drive.yaml"), model);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(sentence("ratio: 97.74", "ratio: 0", modelFile), HasSubstr("transmission_ratio"));
  EXPECT_THAT(sentence("inertia_kg_m2: 5.0e-5, ", "", modelFile), HasSubstr("inertia_kg_m2"));
  EXPECT_THAT(sentence("share: 1.2", "share: -1", modelFile), HasSubstr("0 to 10"));
  const auto extended = [](const std::string& name) {
    FittedModel model = modelFile(name);
    model.extensions = {{"bend-friction", "", {}}};
    return model;
  };
  EXPECT_THAT(sentence("97.74", "97.74", extended), HasSubstr("found causes that were added to the friction law"));
}

}  // namespace
}  // namespace simgap::test
