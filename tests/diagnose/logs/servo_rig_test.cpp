// The simulated drives that stand still do what they are said to do: otherwise a study on them says nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reality/servo_draws.h"

namespace simgap::test {
namespace {

using reality::drawServoEffect;
using reality::drawServoNone;
using reality::expectedGain;
using reality::Mechanism;
using reality::recordServo;
using reality::ServoDraw;
using reality::ServoRecord;
using reality::ServoRig;

class ServoRigTest : public testing::TestWithParam<Mechanism> {
 protected:
  ServoDraw draw_ = [] {
    ServoDraw draw = drawServoNone(3, GetParam());
    draw.rig.rows = 6000;
    return draw;
  }();
};

TEST_P(ServoRigTest, StandsStillForAGoodPartOfTheLogAndMovesForAnother) {
  const ServoRecord r = recordServo(draw_.rig, draw_.secret);
  const auto moving = std::ranges::count(r.moving, true);
  EXPECT_GT(moving, 0.2 * static_cast<double>(r.moving.size()));
  EXPECT_LT(moving, 0.95 * static_cast<double>(r.moving.size()));
}

TEST_P(ServoRigTest, EffortsAtRestFillABandAndMovingOnesDoNot) {
  ServoRig& rig = draw_.rig;
  rig.effort_noise = 0.0;
  const ServoRecord r = recordServo(rig, draw_.secret);
  int inside = 0, rests = 0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    if (std::fabs(r.speed[i]) > 1e-4 * rig.top_speed) continue;
    const double dry = rig.breakaway * (rig.dry + rig.dry_per_load * std::fabs(r.load[i]));
    const double beyond = rig.strength * r.effort[i] - r.load[i];  // what friction has to hold
    EXPECT_LE(std::fabs(beyond), 1.1 * dry + 0.02 * rig.strength * rig.largest_effort);
    ++rests;
    inside += std::fabs(beyond) < 0.7 * dry ? 1 : 0;
  }
  EXPECT_GT(rests, 100);
  EXPECT_GT(inside, rests / 10);
}

TEST_P(ServoRigTest, AnEncoderIsAllThatIsKnownOfTheMotion) {
  const ServoRecord r = recordServo(draw_.rig, draw_.secret);
  const std::string csv = r.csv();
  EXPECT_EQ(csv.find("velocity"), std::string::npos);
  const double count = 2.0 * M_PI / draw_.rig.counts;
  int spikes = 0;
  for (std::size_t i = 1; i + 1 < r.time.size(); ++i) {
    if (r.session[i - 1] != r.session[i + 1]) continue;
    const double step = r.position[i] - 0.5 * (r.position[i - 1] + r.position[i + 1]);
    const double usual = draw_.rig.top_speed / draw_.rig.rate;
    spikes += std::fabs(step) > 18.0 * count + usual ? 1 : 0;
  }
  EXPECT_LE(spikes, 0.002 * static_cast<double>(r.time.size()));
  EXPECT_EQ(csv, recordServo(draw_.rig, draw_.secret).csv());
}

INSTANTIATE_TEST_SUITE_P(Mechanisms, ServoRigTest,
                         testing::Values(Mechanism::kCable, Mechanism::kGearedJoint, Mechanism::kPendulum,
                                         Mechanism::kVoltageServo));

TEST(ServoSecrets, WhatTheyAddIsKnown) {
  ServoDraw draw = drawServoNone(4, Mechanism::kCable);
  draw.rig.rows = 6000;
  const ServoRecord plain = recordServo(draw.rig, draw.secret);
  for (const double extra : plain.extra) ASSERT_NEAR(extra, 0.0, 1e-9);
  draw.secret.dry_offset = 0.5;
  const ServoRecord r = recordServo(draw.rig, draw.secret);
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    if (std::fabs(r.speed[i]) < 0.1 * draw.rig.top_speed) continue;
    // Constant from rest to top speed, in the motion's direction (a bristle is a hair below it).
    ASSERT_NEAR(r.extra[i], std::copysign(0.5 / draw.rig.strength, r.speed[i]), 0.05 / draw.rig.strength);
  }
}

TEST(ServoSecrets, AreDrawnWithAGainOfAtMostSixtyPercent) {
  for (const std::string effect : {"speed-limit", "backlash", "bend-friction", "position-ripple"}) {
    for (const std::uint64_t seed : {17u, 18u}) {
      const ServoDraw draw = drawServoEffect(effect, seed);
      EXPECT_GT(draw.magnitude, 0.0) << effect;
      const double gain = expectedGain(draw.rig, draw.secret);
      EXPECT_LT(gain, 0.75) << effect;
    }
  }
}

}  // namespace
}  // namespace simgap::test
