// The line that collides with the skeleton (000 eq. 7) against the shortest way over a cylinder, and an arm that it
// holds against the one whose line bends over a surface of that shape.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>

#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/evaluator.h"
#include "simgap/simulate/pose_protocol.h"
#include "support/files.h"

namespace simgap {
namespace {

using testing::HasSubstr;

enum class LineKind { kStraight, kWrapped, kRope };

/// A forearm about x, held from in front by a muscle that a roll of 25 mm at the elbow lies in the way of.
ArmModel armWithARoll(LineKind kind) {
  const std::string over = kind == LineKind::kWrapped ? "{over: round, body: base}, " : "";
  const std::string line = kind == LineKind::kRope ? "    line: rope\n" : "";
  const std::string text = R"(
format: simgap/arm/2
name: roll
gravity_m_s2: [0, 0, -9.81]
bodies:
  - name: base
    fixed: true
    parts: [{name: roll, shape: cylinder, radius_m: 0.025, length_m: 0.2, axis: [1, 0, 0], mass_kg: 0.1, position_m: [0, 0.03, 0.02]}]
    surfaces: [{name: round, shape: cylinder, radius_m: 0.0255, axis: [1, 0, 0], position_m: [0, 0.03, 0.02]}]
  - name: forearm
    parts: [{name: load, shape: sphere, radius_m: 0.02, mass_kg: 1.2, position_m: [0, 0, -0.2]}]
joints:
  - {name: elbow, type: revolute, parent: base, child: forearm, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0],
     axis: [1, 0, 0], lower_limit_rad: -2.5, upper_limit_rad: 2.5, coulomb_friction_Nm: 0, viscous_friction_Nms: 0.4}
motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.0105, torque_constant_Nm_A: 0.0105, inertia_kg_m2: 1.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.001, supply_voltage_V: 12}
gearbox_defaults: {ratio: 74, efficiency: 0.7, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.001, coulomb_friction_Nm: 0.01}
muscles:
  - name: flexor
    attachments: [{body: base, point_m: [0, 0.045, 0.2]}, )" +
                           over + R"({body: forearm, point_m: [0, 0.02, -0.1]}]
)" + line + R"(    kite_line_length_m: 0.2
    shock_cord: {rest_length_m: 0.1, stiffness_N_m: 1500, damping_Ns_m: 20}
    spindle_radius_m: 0.006
)";
  return readArm(YamlNode::parse(text, "roll.yaml"));
}

std::vector<double> restsOf(LineKind kind, double& step_us) {
  BulletArm arm(armWithARoll(kind), {});
  PoseProtocol protocol;
  protocol.settle = 20.0;
  std::vector<double> angles;
  const std::clock_t begin = std::clock();
  double time = 0.0;
  for (const double shaft : {4.0, 8.0, 12.0, 16.0}) {
    const PoseOutcome outcome = replayPose(arm, {{shaft}}, protocol);
    EXPECT_EQ(outcome.status, PoseStatus::kSteady) << shaft << " rad";
    angles.push_back(outcome.joints.empty() ? NAN : outcome.joints[0].angle);
    time += arm.time();
  }
  step_us = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / (time / 0.002);
  return angles;
}

TEST(Rope, HoldsAnArmAsALineOverTheSameSurfaceDoes) {
  double rope_us = 0.0, wrapped_us = 0.0, straight_us = 0.0;
  const std::vector<double> rope = restsOf(LineKind::kRope, rope_us), wrapped = restsOf(LineKind::kWrapped, wrapped_us),
                            straight = restsOf(LineKind::kStraight, straight_us);
  double apart = 0.0, straight_apart = 0.0;
  for (std::size_t i = 0; i < rope.size(); ++i) {
    apart = std::max(apart, toDegrees(std::abs(rope[i] - wrapped[i])));
    straight_apart = std::max(straight_apart, toDegrees(std::abs(straight[i] - wrapped[i])));
  }
  fmt::print(
      "largest difference to the wrapped line: rope {:.2f} deg, straight {:.2f} deg; step {:.1f}, {:.1f}, {:.1f} us "
      "(rope, wrapped, straight)\n",
      apart, straight_apart, rope_us, wrapped_us, straight_us);
  EXPECT_LT(apart, 0.5);
  EXPECT_GT(straight_apart, 5.0 * apart);
}

TEST(Rope, IsTheSameToTheLastBitInEveryPose) {
  BulletArm arm(armWithARoll(LineKind::kRope), {});
  const PoseOutcome first = replayPose(arm, {{8.0}}, {}), again = replayPose(arm, {{8.0}}, {});
  ASSERT_FALSE(first.joints.empty());
  EXPECT_EQ(first.joints[0].angle, again.joints[0].angle);
}

TEST(Rope, IsWrittenAsItWasReadAndUnknownToEquilibria) {
  const ArmModel model = armWithARoll(LineKind::kRope);
  const std::string text = writeArm(model);
  EXPECT_THAT(text, HasSubstr("    line: rope\n"));
  EXPECT_TRUE(readArm(YamlNode::parse(text, "again.yaml")).muscles[0].rope);
  Pose pose;
  pose.shafts = {4.0};
  pose.joints.resize(1);
  EXPECT_THAT(test::errorOf([&] {
                makeEquilibriumEvaluator(1)->evaluate({&model, 1}, {&pose, 1}, AfterInvalid::kGoOn);
              }),
              HasSubstr("muscle 'flexor' is a rope (line: rope), which equilibria do not know"));
}

}  // namespace
}  // namespace simgap
