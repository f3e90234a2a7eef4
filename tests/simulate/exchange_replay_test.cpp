// A robot compared with itself: whatever rounding does to it, it is the same.
#include "simgap/simulate/exchange_replay.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/robot_exchange.h"

namespace simgap::test {
namespace {

/// Six hinges in all directions, of which servos hold all but one, and on the last one two fingers that move against
/// each other: gravity pulls both alike, so nothing says how far they are open. Shape and masses are near those of
/// Franka's Panda.
constexpr const char* kGripper = R"(<mujoco><compiler angle="radian"/><worldbody>
<body name="l1" pos="0 0 0.333"><joint name="j1"/><inertial mass="4.970684" pos="0.003875 0.002081 -0.04762"
 fullinertia="0.70337 0.70661 0.0091170 -0.00013900 0.0067720 0.019169"/>
<body name="l2" quat="1 -1 0 0"><inertial mass="0.646926" pos="-0.003141 -0.02872 0.003495"
 fullinertia="0.0079620 2.8110e-2 2.5995e-2 -3.925e-3 1.0254e-2 7.04e-4"/>
<body name="l3" pos="0 -0.316 0" quat="1 1 0 0"><joint name="j3"/><inertial mass="3.228604"
 pos="2.7518e-2 3.9252e-2 -6.6502e-2" fullinertia="3.7242e-2 3.6155e-2 1.083e-2 -4.761e-3 -1.1396e-2 -1.2805e-2"/>
<body name="l4" pos="0.0825 0 0" quat="1 1 0 0"><joint name="j4" range="-3.0718 -0.0698"/><inertial mass="3.587895"
 pos="-5.317e-2 1.04419e-1 2.7454e-2" fullinertia="2.5853e-2 1.9552e-2 2.8323e-2 7.796e-3 -1.332e-3 8.641e-3"/>
<body name="l5" pos="-0.0825 0.384 0" quat="1 -1 0 0"><joint name="j5"/><inertial mass="1.225946"
 pos="-1.1953e-2 4.1065e-2 -3.8437e-2" fullinertia="3.5549e-2 2.9474e-2 8.627e-3 -2.117e-3 -4.037e-3 2.29e-4"/>
<body name="l6" quat="1 1 0 0"><joint name="j6"/><inertial mass="1.666555" pos="6.0149e-2 -1.4117e-2 -1.0517e-2"
 fullinertia="1.964e-3 4.354e-3 5.433e-3 1.09e-4 -1.158e-3 3.41e-4"/>
<body name="l7" pos="0.088 0 0" quat="1 1 0 0"><joint name="j7"/><inertial mass="0.735522"
 pos="1.0517e-2 -4.252e-3 6.1597e-2" fullinertia="1.2516e-2 1.0027e-2 4.815e-3 -4.28e-4 -1.196e-3 -7.41e-4"/>
<body name="hand" pos="0 0 0.107" quat="0.9238795 0 0 -0.3826834"><inertial mass="0.73" pos="-0.01 0 0.03"
 diaginertia="0.001 0.0025 0.0017"/>
<body name="left" pos="0 0 0.0584"><joint name="f1" type="slide" axis="0 1 0" range="0 0.04"/><inertial mass="0.015"
 pos="0 0 0" diaginertia="2.375e-6 2.375e-6 7.5e-7"/></body>
<body name="right" pos="0 0 0.0584" quat="0 0 0 1"><joint name="f2" type="slide" axis="0 1 0" range="0 0.04"/>
<inertial mass="0.015" pos="0 0 0" diaginertia="2.375e-6 2.375e-6 7.5e-7"/></body>
</body></body></body></body></body></body></body></body></worldbody>
<equality><joint joint1="f1" joint2="f2"/></equality><actuator>
<general joint="j1" biastype="affine" gainprm="4500" biasprm="0 -4500 -450"/>
<general joint="j3" biastype="affine" gainprm="3500" biasprm="0 -3500 -350"/><general joint="j4"/>
<general joint="j5" biastype="affine" gainprm="2000" biasprm="0 -2000 -200"/>
<general joint="j6" biastype="affine" gainprm="2000" biasprm="0 -2000 -200"/>
<general joint="j7" biastype="affine" gainprm="2000" biasprm="0 -2000 -200"/></actuator></mujoco>)";

TEST(ExchangeReplay, WhatIsIndifferentIsNotComparedInsteadOfTakenForAnotherRobot) {
  const ArmModel arm = readMjcf(kGripper, "gripper.xml", {}).model;
  const ExchangeReplay replay = replayExchange(arm, arm, false);
  EXPECT_EQ(replay.restless, 0) << "the same robot";
  EXPECT_GT(replay.rests, 0);
  EXPECT_EQ(replay.rests + replay.not_compared, 20);
  EXPECT_LT(replay.rest_way, 1e-12);
}

/// A finger whose inertia alone was lost on the way stands and rests where it did: only its inertia tells.
TEST(ExchangeReplay, SeesAnInertiaThatRestsDoNotSee) {
  const ArmModel arm = readMjcf(kGripper, "gripper.xml", {}).model;
  std::string changed = kGripper;
  const std::string finger = "diaginertia=\"2.375e-6 2.375e-6 7.5e-7\"";
  changed.replace(changed.find(finger), finger.size(), "diaginertia=\"2.375e-6 2e-6 7.5e-7\"");
  const ExchangeReplay replay = replayExchange(arm, readMjcf(changed, "changed.xml", {}).model, false);
  EXPECT_NEAR(replay.inertia, 0.375 / std::hypot(2.375, 2.375, 0.75), 1e-9);
  EXPECT_EQ(replay.mass, 0.0);
  EXPECT_LT(replay.centre, 1e-12);
  EXPECT_LT(replay.way, 1e-12);
}

/// Other formats have no swing and twist of a ball; a remark says so, and the rest is the same robot.
TEST(ExchangeReplay, RestsAreComparedWithoutLimitsThatTheOtherHasNot) {
  const auto ballWith = [](const std::string& limits) {
    return readArm(YamlNode::parse(R"(format: simgap/arm/2
name: ball
gravity_m_s2: [0, 0, -9.81]
bodies:
  - {name: base, fixed: true}
  - {name: up, parts: [{name: a, shape: sphere, radius_m: 0.03, mass_kg: 1, position_m: [0.1, 0, -0.1]}]}
joints:
  - {name: sh, type: spherical, parent: base, child: up, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0],
     coulomb_friction_Nm: 0.001, viscous_friction_Nms: 0.5)" +
                                       limits + R"(}
motor_defaults: {resistance_ohm: 2.0, inductance_H: 0.0005, back_emf_constant_Vs: 0.02, torque_constant_Nm_A: 0.02,
  inertia_kg_m2: 1.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.001, supply_voltage_V: 24}
gearbox_defaults: {ratio: 60, efficiency: 0.7, inertia_kg_m2: 1.0e-6, viscous_friction_Nms: 0.001,
  coulomb_friction_Nm: 0.01}
muscles:
  - {name: m, attachments: [{body: base, point_m: [0.1, 0, 0.1]}, {body: up, point_m: [0.05, 0, -0.1]}],
     kite_line_length_m: 0.05, spindle_radius_m: 0.01,
     shock_cord: {rest_length_m: 0.1, stiffness_N_m: 100, damping_Ns_m: 6}}
  - {name: m2, attachments: [{body: base, point_m: [0, 0.1, 0.1]}, {body: up, point_m: [0.0, 0.05, -0.1]}],
     kite_line_length_m: 0.05, spindle_radius_m: 0.01,
     shock_cord: {rest_length_m: 0.1, stiffness_N_m: 100, damping_Ns_m: 6}}
)",
                                   "ball.yaml"));
  };
  const ArmModel limited = ballWith(", limits: {axis: [0, 0, 1], swing_rad: 0.3, stiffness_Nm_rad: 40}");
  const ExchangeReplay without = replayExchange(limited, ballWith(""), false);
  EXPECT_GT(without.rests, 0);
  EXPECT_EQ(without.restless, 0);
  EXPECT_LT(without.rest_turn, 1e-9);
  // Kept, they count.
  const ArmModel wider = ballWith(", limits: {axis: [0, 0, 1], swing_rad: 0.9, stiffness_Nm_rad: 40}");
  EXPECT_GT(replayExchange(limited, wider, false).rest_turn, 0.1);
}

/// A body of two joints away from its origin is two bodies here, of which the first weighs nothing and has no centre.
TEST(ExchangeReplay, WhatWeighsNothingHasNoCentreToCompare) {
  const RobotFile two_joints = {
      "<mujoco model='two'><worldbody><body name='a'><joint name='j1' pos='0 0 .3' axis='0 0 1'/><joint name='j2' "
      "pos='0 0 .3' axis='0 1 0'/><geom type='capsule' fromto='0 0 .3 .1 0 .3' "
      "size='.018'/></body></worldbody></mujoco>",
      "two.xml"};
  const RobotExchange urdf = exchangeRobot(two_joints, {}, "two.urdf", {});
  EXPECT_LT(urdf.replay.centre, 1e-12);
  EXPECT_LT(urdf.replay.way, 1e-12);
  const RobotFile massless = {
      "<robot name='r'><link name='world'/><link name='a'/><link name='b'><inertial><origin xyz='0.1 0 0'/><mass "
      "value='1'/><inertia ixx='0.01' iyy='0.02' izz='0.025'/></inertial></link><joint name='j1' type='continuous'>"
      "<parent link='world'/><child link='a'/></joint><joint name='j2' type='continuous'><origin xyz='0.2 0 0'/>"
      "<parent link='a'/><child link='b'/></joint></robot>",
      "r.urdf"};
  const RobotExchange mjcf = exchangeRobot(massless, {}, "r.xml", {});
  EXPECT_LT(mjcf.replay.inertia, 1e-9);
  EXPECT_LT(mjcf.replay.mass, 1e-9) << "MuJoCo's milligram is none";
}

}  // namespace
}  // namespace simgap::test
