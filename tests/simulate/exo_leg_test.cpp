// The leg that stands up: its equations against energy and a pendulum, its lifting torques against the gradient of
// height.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/simulate/exo_leg_motion.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

ExoLeg sampleLeg() { return readExoLeg(YamlNode::load(sourceFile("data/exoskeleton/leg.yaml"))); }

/// Nothing but links, masses and gravity, hanging free of its seat.
ExoLeg bareLeg() {
  ExoLeg leg = sampleLeg();
  leg.viscous = {};
  leg.user = {};
  leg.seat_stiffness = leg.seat_damping = 0.0;
  return leg;
}

/// Height of the centre of mass from the three places of the masses, written out.
double heightOfMasses(const ExoLeg& leg, double ankle, double knee) {
  const PlanarLeg& l = leg.leg;
  const double of_knee = l.shank.length * std::cos(ankle);
  const double of_shank = l.shank.centre * std::cos(ankle),
               of_thigh = of_knee + l.thigh.centre * std::cos(ankle + knee);
  const double of_hip = of_knee + l.thigh.length * std::cos(ankle + knee);
  return (l.shank.mass * of_shank + l.thigh.mass * of_thigh + l.load * of_hip) / (l.shank.mass + l.thigh.mass + l.load);
}

TEST(PlanarLeg, LiftsAlongTheGradientOfItsHeight) {
  const ExoLeg leg = sampleLeg();
  constexpr double kStep = 1e-5, kForce = 300.0;
  for (const auto& [ankle, knee] : {std::pair{0.2, -1.7}, std::pair{0.5, -0.9}, std::pair{-0.1, 0.0}}) {
    const LegTorques torques = leg.leg.lifting(ankle, knee, kForce);
    const auto slope = [&, ankle = ankle, knee = knee](double by_ankle, double by_knee) {
      return (heightOfMasses(leg, ankle + by_ankle, knee + by_knee) -
              heightOfMasses(leg, ankle - by_ankle, knee - by_knee)) /
             (2.0 * kStep);
    };
    EXPECT_NEAR(torques[0], kForce * slope(kStep, 0.0), 1e-6);
    EXPECT_NEAR(torques[1], kForce * slope(0.0, kStep), 1e-6);
    EXPECT_NEAR(leg.leg.centreHeight(ankle, knee), heightOfMasses(leg, ankle, knee), 1e-12);
  }
}

/// With the whole weight the leg floats: it stays wherever it is.
TEST(VerticalAssist, TheWholeWeightIsGravityCompensation) {
  const ExoLeg leg = bareLeg();
  ExoLegMotion motion(leg);
  motion.reset(0.3, -1.2);
  for (int i = 0; i < 2000; ++i) {
    motion.step(leg.leg.lifting(motion.ankle(), motion.knee(), leg.leg.mass() * leg.leg.gravity), 1e-3);
  }
  EXPECT_NEAR(motion.ankle(), 0.3, 1e-9);
  EXPECT_NEAR(motion.knee(), -1.2, 1e-9);
}

TEST(VerticalAssist, KeepsItsLimitsAndComesGradually) {
  const ExoLeg leg = sampleLeg();
  VerticalAssist assist{.share = 1.0, .limits = {30.0, 200.0}, .rise_time = 0.5};
  double level = 0.0;
  assist.update(leg.leg, 0.2, -1.6, true, 0.5, level);
  EXPECT_NEAR(level, 1.0 - std::exp(-1.0), 1e-12);
  const LegTorques torques = assist.update(leg.leg, 0.2, -1.6, true, 10.0, level);
  EXPECT_EQ(torques[0], 30.0);
  EXPECT_GT(torques[1], 100.0);
  EXPECT_LT(torques[1], 200.0);
}

TEST(ExoLegMotion, KeepsItsEnergyWithoutFriction) {
  ExoLegMotion motion(bareLeg());
  motion.reset(2.0, -1.5);
  const double before = motion.energy();
  double fastest = 0.0;
  for (int i = 0; i < 30000; ++i) {
    if (motion.knee() > -0.05) break;  // its stop takes energy
    motion.step({}, 1e-4);
    fastest = std::max(fastest, std::abs(motion.ankleVelocity()));
  }
  EXPECT_GT(fastest, 2.0);
  EXPECT_NEAR(motion.energy(), before, 1e-6 * std::abs(before));
}

/// Without a thigh worth mentioning the shank is a pendulum that hangs down: its period is 4 K(sin(swing / 2)) /
/// omega_0.
TEST(ExoLegMotion, OneLinkIsAPendulum) {
  ExoLeg leg = bareLeg();
  leg.leg.load = 0.0;
  leg.leg.thigh = {1e-6, 0.0, 1e-9};
  leg.thigh_inertia = 1e-3;
  const double inertia = leg.shank_inertia + leg.leg.shank.mass * std::pow(leg.leg.shank.centre, 2);
  const double omega = std::sqrt(leg.leg.shank.mass * leg.leg.gravity * leg.leg.shank.centre / inertia);
  const double swing = 0.7, period = 4.0 * std::comp_ellint_1(std::sin(0.5 * swing)) / omega;
  ExoLegMotion motion(leg);
  motion.reset(M_PI - swing, -2.0);
  for (int i = 0; i < 20000; ++i) motion.step({}, period / 20000.0);
  EXPECT_NEAR(motion.ankle(), M_PI - swing, 1e-5);
}

TEST(ExoLegStudy, StandsUpAsToldWithTheExoskeletonAlone) {
  const LegSwitch told = readLegSwitch(CsvTable::load(sourceFile("data/exoskeleton/switch.csv")));
  const ExoLegStudy study = studyExoLeg(sampleLeg(), told, told.times.back(), 1e-3);
  ASSERT_EQ(study.runs.size(), 2U);
  EXPECT_GT(study.runs[0].standing, 0.5);
  EXPECT_EQ(study.runs[1].standing, 0.0);
  EXPECT_GT(study.runs[0].track.hip.at(7 * 500), 0.78);   // at 7 s, told up since 2
  EXPECT_LT(study.runs[0].track.hip.at(13 * 500), 0.43);  // at 13 s, told down since 8
  EXPECT_LT(study.half_step, 1e-3);
}

/// A step beyond the controller's tick is the tick, and half of it is half of what was taken.
TEST(ExoLegStudy, SaysWhichStepItTookAndWhatHalfOfItChanges) {
  const LegSwitch told = readLegSwitch(CsvTable::load(sourceFile("data/exoskeleton/switch.csv")));
  const ExoLegStudy coarse = studyExoLeg(sampleLeg(), told, 10.0, 0.01);
  EXPECT_NEAR(coarse.step, 2e-3, 1e-12);
  EXPECT_GT(coarse.half_step, 0.0);
  EXPECT_TRUE(coarse.notes.empty());
  ExoLeg stiff = sampleLeg();
  stiff.seat_stiffness = 1e11;
  const ExoLegStudy study = studyExoLeg(stiff, told, told.times.back(), 1e-4);
  ASSERT_EQ(study.notes.size(), 1U) << study.half_step;
  EXPECT_THAT(study.notes[0], HasSubstr("the step of 0.0001 s is too large"));
}

TEST(ExoLegFile, RefusesWhatNoLegIs) {
  const std::string text = readText(sourceFile("data/exoskeleton/leg.yaml"));
  const auto refusal = [&](const std::string& from, const std::string& to) {
    return errorOf([&] { readExoLeg(YamlNode::parse(replaced(text, from, to), "leg.yaml")); });
  };
  EXPECT_THAT(refusal("sitting_deg: -97", "sitting_deg: -12"), HasSubstr("a seat on which the leg stands"));
  EXPECT_THAT(refusal("share: 0.6", "share: 1.6"), HasSubstr("expected a number from 0 to 1"));
  EXPECT_THAT(refusal("mass_kg: 7.8", "mass_kg: 0"), HasSubstr("mass_kg"));
  EXPECT_THAT(refusal("load_kg", "loads_kg"), HasSubstr("load"));
}

TEST(LegSwitch, ReadsStatesOfADecoder) {
  const auto read = [](const std::string& text) { return readLegSwitch(CsvTable::parse(text, "decoded.csv")); };
  const LegSwitch told = read("time_s,probability_up,state\n0,0.5,none\n1,0.8,up\n2,0.5,none\n3,0.2,down\n");
  EXPECT_EQ(told.up, (std::vector<bool>{false, true, true, false}));
  EXPECT_THAT(errorOf([&] { read("time_s,state\n0,up\n1,left\n"); }),
              HasSubstr("decoded.csv:3: found the state 'left', expected up, down or none"));
  EXPECT_THAT(errorOf([&] { read("time_s,state\n1,up\n0,up\n"); }), HasSubstr("expected rising times"));
}

}  // namespace
}  // namespace simgap::test
