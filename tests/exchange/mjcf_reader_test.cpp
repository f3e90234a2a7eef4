// MJCF by hand: what each construct means is worked out here, not by the reader.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "mjcf_texts.h"
#include "simgap/core/error.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

TEST(MjcfReader, ReadsAHingeInDegreesWithDefaultsOfItsClass) {
  const ArmModel arm = readText(robot("<default><joint damping='0.5'/><default class='c'><joint range='-90 45'/>"
                                      "</default></default>\n",
                                      std::string("<joint name='h' class='c' axis='0 2 0' stiffness='3' springref='30' "
                                                  "frictionloss='0.1'/>\n") +
                                          kBall))
                           .model;
  ASSERT_EQ(arm.joints.size(), 1U);
  const Joint& joint = arm.joints[0];
  EXPECT_EQ(joint.type, JointType::kRevolute);
  EXPECT_EQ(joint.axis, Eigen::Vector3d::UnitY());
  EXPECT_DOUBLE_EQ(joint.lower_limit, -std::numbers::pi / 2.0);
  EXPECT_DOUBLE_EQ(joint.upper_limit, std::numbers::pi / 4.0);
  EXPECT_DOUBLE_EQ(joint.viscous_friction, 0.5);
  EXPECT_DOUBLE_EQ(joint.coulomb_friction, 0.1);
  EXPECT_DOUBLE_EQ(joint.spring_stiffness, 3.0);
  EXPECT_DOUBLE_EQ(joint.spring_rest, std::numbers::pi / 6.0);
}

TEST(MjcfReader, CountsPositionsFromTheDrawnPose) {
  const ImportedArm read =
      readText(robot("<compiler angle='radian'/>", std::string("<joint name='h' ref='0.5' range='0 1'/>\n") + kBall));
  EXPECT_DOUBLE_EQ(read.model.joints[0].lower_limit, -0.5);
  EXPECT_DOUBLE_EQ(read.model.joints[0].upper_limit, 0.5);
  EXPECT_TRUE(hasRemark(read.remarks, "joint ref", true, "robot.xml:4"));
}

TEST(MjcfReader, TurnsFramesByEveryNotation) {
  // 90 degrees about z in each of them; small letters of eulerseq turn with the body, capitals do not.
  const Eigen::Vector3d expected(0.0, 1.0, 0.0);
  for (const std::string frame :
       {"quat='1 0 0 1'", "axisangle='0 0 3 90'", "euler='0 0 90'", "xyaxes='0 2 0 -1 1 0'"}) {
    const ArmModel arm = readText("<mujoco><worldbody><body pos='1 2 3' " + frame + "><joint name='h'/>" + kBall +
                                  "</body></worldbody></mujoco>")
                             .model;
    const std::vector<BodyInWorld> bodies = bodiesInWorld(arm, std::vector<JointPosition>(1));
    EXPECT_NEAR((bodies[1].rotation * Eigen::Vector3d::UnitX() - expected).norm(), 0.0, 1e-12) << frame;
    EXPECT_NEAR((bodies[1].origin - Eigen::Vector3d(1, 2, 3)).norm(), 0.0, 1e-12) << frame;
  }
  const auto turned = [](const std::string& sequence) {
    const ArmModel arm =
        readText("<mujoco><compiler eulerseq='" + sequence + "'/><worldbody><body euler='90 90 0'><joint/>" + kBall +
                 "</body></worldbody></mujoco>")
            .model;
    return Eigen::Vector3d(bodiesInWorld(arm, std::vector<JointPosition>(1))[1].rotation * Eigen::Vector3d::UnitZ());
  };
  EXPECT_NEAR((turned("xyz") - Eigen::Vector3d::UnitX()).norm(), 0.0, 1e-12);  // Rx Ry z = Rx x
  EXPECT_NEAR((turned("XYZ") + Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-12);  // Ry Rx z = Ry (-y)
}

TEST(MjcfReader, AddsTheMassOfGeomsAndOfWeldedBodies) {
  const ArmModel arm = readText(robot("",
                                      "<joint/>\n<geom type='box' size='0.1 0.2 0.3' mass='3'/>\n"
                                      "<body pos='0 0 1'><geom size='0.1' mass='1'/></body>\n"))
                           .model;
  ASSERT_EQ(arm.bodies.size(), 2U);
  const MassProperties mass = massProperties(arm.bodies[1]);
  EXPECT_DOUBLE_EQ(mass.mass, 4.0);
  EXPECT_NEAR(mass.centre_of_mass.z(), 0.25, 1e-15);
  // Box 3/3 (0.2^2 + 0.3^2), ball 2/5 0.1^2, both moved: 3 * 0.25^2 + 1 * 0.75^2.
  EXPECT_NEAR(mass.inertia(0, 0), 0.13 + 0.004 + 0.1875 + 0.5625, 1e-12);
}

TEST(MjcfReader, PrefersStatedInertia) {
  const ArmModel arm = readText(robot("",
                                      "<joint/>\n<geom size='1'/>\n<inertial mass='2' pos='0.1 0 0' quat='1 0 0 1' "
                                      "diaginertia='1 2 2.5'/>\n<geom size='2'/>\n"))
                           .model;
  const MassProperties mass = massProperties(arm.bodies[1]);
  EXPECT_DOUBLE_EQ(mass.mass, 2.0);
  EXPECT_NEAR((mass.inertia.diagonal() - Eigen::Vector3d(2, 1, 2.5)).norm(), 0.0, 1e-12);
}

TEST(MjcfReader, MakesABodyOfEveryJoint) {
  const ArmModel arm =
      readText(
          robot("", std::string("<joint name='yaw'/>\n<joint name='pitch' axis='0 1 0' pos='0 0 0.2'/>\n") + kBall))
          .model;
  ASSERT_EQ(arm.bodies.size(), 3U);
  EXPECT_EQ(arm.bodies[2].name, "b");
  EXPECT_EQ(massProperties(arm.bodies[1]).mass, 0.0);
  std::vector<JointPosition> joints(2);
  joints[0].angle = std::numbers::pi / 2.0;
  joints[1].angle = std::numbers::pi / 2.0;
  // The origin, 0.2 below the second joint, swings to -x of the body that yaw has turned: -y.
  const std::vector<BodyInWorld> bodies = bodiesInWorld(arm, joints);
  EXPECT_NEAR((bodies[2].origin - Eigen::Vector3d(0.0, -0.2, 0.2)).norm(), 0.0, 1e-12);
}

TEST(MjcfReader, ReadsPathsWithBranchesTheFullOneFirst) {
  const ArmModel arm = readText(std::string("<mujoco><worldbody><site name='up' pos='0.3 0 0.4'/><site name='near' "
                                            "pos='0.3 0 0.1'/><body><joint/><site name='in' pos='0.3 0 0'/>") +
                                kBall +
                                "</body></worldbody><tendon><spatial name='t' stiffness='10'><pulley divisor='2'/>"
                                "<site site='in'/><site site='up'/><pulley divisor='1'/><site site='in'/>"
                                "<site site='near'/></spatial></tendon></mujoco>")
                           .model;
  ASSERT_EQ(arm.tendons.size(), 1U);
  const std::vector<JointPosition> drawn(1);
  EXPECT_NEAR(tendonLength(arm, arm.tendons[0], bodiesInWorld(arm, drawn), drawn), 0.1 + 0.5 * 0.4, 1e-12);
  EXPECT_NEAR(arm.tendons[0].p[0], 0.3, 1e-12) << "a spring without a length rests where the joint springs do";
}

TEST(MjcfReader, NamesWhatItLeavesOutWithItsLine) {
  const ImportedArm read = readText(robot(
      "<option wind='1 0 0'/>\n",
      std::string("<joint armature='0.1' magic='2'/>\n") + kBall + "<joint name='j2'/>\n<composite type='rope'/>\n",
      "<actuator><velocity joint='j2'/></actuator>\n<keyframe/>\n"));
  EXPECT_TRUE(hasRemark(read.remarks, "option wind", true, "robot.xml:2"));
  EXPECT_TRUE(hasRemark(read.remarks, "joint armature", true, "robot.xml:5"));
  EXPECT_TRUE(hasRemark(read.remarks, "joint magic", true, "robot.xml:5"));
  EXPECT_TRUE(hasRemark(read.remarks, "composite", true, "robot.xml:8"));
  EXPECT_TRUE(hasRemark(read.remarks, "velocity (actuator of a joint)", true, "robot.xml:11"));
  EXPECT_TRUE(hasRemark(read.remarks, "keyframe", false, "robot.xml:12"));
}

TEST(MjcfReader, MotorsAndServosOfHingesTurnThem) {
  const ImportedArm read =
      readText(robot("", std::string("<joint name='h'/>\n<joint name='k' type='ball'/>\n") + kBall,
                     "<actuator><motor name='drive' joint='h' gear='-5'/><position joint='h' kp='20' kv='2' gear='2'/>"
                     "<motor joint='k'/></actuator>"));
  ASSERT_EQ(read.model.tendons.size(), 2U);
  const PassiveTendon &motor = read.model.tendons[0], &servo = read.model.tendons[1];
  EXPECT_EQ(motor.name, "drive");
  EXPECT_DOUBLE_EQ(motor.kind->pull(motor.p, 0.3, 2.0).force, 10.0) << "minus gear times control";
  EXPECT_DOUBLE_EQ(motor.kind->force(motor.p, 0.3, 7.0, 2.0), 10.0);
  // gear (kp ctrl - kp gear q - kv gear dq/dt), with the control twice the target
  EXPECT_DOUBLE_EQ(servo.kind->force(servo.p, 0.3, 0.1, 0.5), -2.0 * (20.0 * 1.0 - 20.0 * 2.0 * 0.3 - 2.0 * 2.0 * 0.1));
  EXPECT_TRUE(hasRemark(read.remarks, "motor (actuator of a joint)", true, "robot.xml:9")) << "a ball has no axis";
}

TEST(MjcfReader, ASideSiteMayBeOnAnotherBodyThanItsSurface) {
  const std::string sites =
      "<mujoco><worldbody><site name='up' pos='0 .3 0'/><geom name='w' size='.05 .1' type='cylinder' zaxis='1 0 0' "
      "pos='0 .15 0' mass='0'/><body><joint type='slide' axis='0 0 1'/><site name='in' pos='0 0 0'/>"
      "<site name='side' pos='0 .15 .2'/>";
  const ArmModel arm = readText(sites + kBall +
                                "</body></worldbody><tendon><spatial name='t' stiffness='9'><site site='in'/>"
                                "<geom geom='w' sidesite='side'/><site site='up'/></spatial></tendon></mujoco>")
                           .model;
  ASSERT_EQ(arm.tendons[0].between.size(), 1U);
  EXPECT_EQ(arm.bodies[arm.tendons[0].between[0].side_body].name, arm.bodies[1].name);
  // The slide carries the side point from above the wheel to below it, and the line goes along with it.
  for (const double way : {0.02, -0.02, -0.25, -0.3}) {
    const std::vector<JointPosition> at = {{Eigen::Quaterniond::Identity(), way}};
    const double above = tendonLength(arm, arm.tendons[0], bodiesInWorld(arm, at), at);
    const double sign = way > -0.2 ? 1.0 : -1.0;
    const double d0 = std::hypot(0.15, way), d1 = 0.15, r = 0.05;
    const double l0 = std::sqrt(d0 * d0 - r * r), l1 = std::sqrt(d1 * d1 - r * r);
    const double between = std::numbers::pi - sign * std::atan2(way, 0.15);  // of the two ends, on the side's side
    const double arc = between - std::acos(r / d0) - std::acos(r / d1);
    const double straight = std::hypot(0.3, way);
    EXPECT_NEAR(above, arc > 0.0 ? l0 + l1 + r * arc : straight, 1e-9) << way;
  }
}

TEST(MjcfReader, RefusesWithOneSentence) {
  const std::string hinge = std::string("<joint name='h'/>\n") + kBall;
  EXPECT_EQ(refusal("<mujoco>"),
            "robot.xml:1: found no XML that can be read (XML_ERROR_MISMATCHED_ELEMENT), expected a robot in XML");
  EXPECT_THAT(refusal(robot("", "<freejoint/>\n")), HasSubstr("robot.xml:4: freejoint: found a floating base"));
  EXPECT_THAT(refusal(robot("", hinge, "<equality><weld body1='b'/></equality>")), HasSubstr("found a closed loop"));
  EXPECT_THAT(refusal(robot("", "<joint range='0 nan'/>\n")),
              HasSubstr("range: found 'nan', expected a finite number"));
  EXPECT_THAT(refusal(robot("", "<joint range='2 1' limited='true'/>\n")), HasSubstr("range: found 2 above 1"));
  EXPECT_THAT(refusal(robot("", "<joint class='none'/>\n")), HasSubstr("class: found 'none'"));
  EXPECT_THAT(refusal(robot("", "<joint/>\n<geom size='-1'/>\n")), HasSubstr("size: found -1 of a sphere"));
  EXPECT_THAT(refusal(robot("", "<joint/>\n")), HasSubstr("body 'b' moves without any mass"));
  EXPECT_THAT(refusal(robot("", hinge, "<tendon><spatial><site site='x'/></spatial></tendon>")),
              HasSubstr("found 'x', expected the name of a site"));
  EXPECT_THAT(refusal(robot("", hinge + "<site name='x'/>", "<tendon><spatial><site site='x'/></spatial></tendon>")),
              HasSubstr("found a path of 1 sites, expected at least two"));
  EXPECT_THAT(refusal(robot("", hinge, "<actuator><motor joint='x'/></actuator>")),
              HasSubstr("found 'x', expected the name of a hinge or slide"));
  EXPECT_THAT(refusal("<!DOCTYPE m [<!ENTITY a 'b'>]>\n" + robot("", hinge)), HasSubstr("found a document type"));
  EXPECT_THAT(refusal(std::string(20000, '<')), HasSubstr("found no XML"));
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "<body>";
  EXPECT_THAT(refusal("<mujoco><worldbody>" + deep), HasSubstr("found elements nested deeper than 100"));
}

TEST(MjcfReader, WhatDrivesNoHingeIsSaidToBeWhatItIs) {
  const ImportedArm read = readText(
      robot("", std::string("<joint name='h'/>\n<joint name='s' type='slide'/>\n<site name='tip'/>\n") + kBall,
            "<actuator>\n<motor jointinparent='h' gear='5'/>\n<general site='tip'/>\n<general cranksite='tip'/>\n"
            "<motor joint='s'/>\n<muscle joint='h'/>\n<velocity joint='h'/>\n</actuator>"));
  const auto said = [&](const std::string& place) {
    for (const ExchangeRemark& remark : read.remarks) {
      if (std::ranges::find(remark.places, place) != remark.places.end()) return remark.done;
    }
    return std::string();
  };
  ASSERT_EQ(read.model.tendons.size(), 1U) << "of a hinge, jointinparent is joint";
  EXPECT_THAT(said("robot.xml:12"), HasSubstr("it pushes at a site"));
  EXPECT_THAT(said("robot.xml:13"), HasSubstr("it drives a slider-crank"));
  EXPECT_THAT(said("robot.xml:14"), HasSubstr("slides have no motors"));
  EXPECT_THAT(said("robot.xml:15"), HasSubstr("its law is neither a motor's nor a position servo's"));
  EXPECT_THAT(said("robot.xml:16"), HasSubstr("it holds a velocity"));
}

TEST(MjcfReader, AServoMayScaleItsControlAndCountFromTheReference) {
  // MuJoCo: 2 (30 u + 6 - 60 (2 q) - 4 (2 dq/dt)), q from 0.5 in the drawn pose.
  const ImportedArm read = readText(
      robot("<compiler angle='radian'/>\n", std::string("<joint name='h' ref='0.5'/>\n") + kBall,
            "<actuator><general joint='h' gear='2' gainprm='30' biastype='affine' biasprm='6 -60 -4'/></actuator>"));
  ASSERT_EQ(read.model.tendons.size(), 1U);
  const PassiveTendon& servo = read.model.tendons[0];
  const double u = 0.8, q = 0.3, rate = 0.1, target = 0.25 * u;
  EXPECT_NEAR(-servo.kind->force(servo.p, q, rate, target),
              2.0 * (30.0 * u + 6.0 - 60.0 * 2.0 * (q + 0.5) - 4.0 * 2.0 * rate), 1e-12);
  EXPECT_TRUE(std::ranges::any_of(read.remarks, [](const ExchangeRemark& r) {
    return r.done == "a servo whose target is 0.25 of the control" && r.matters;
  }));
  const PassiveTendon back = readText(writeMjcf(read.model).text).model.tendons.at(0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(back.p[i], servo.p[i], 1e-12);
}

TEST(MjcfReader, ALooseThingBesideTheRobotIsLeftOut) {
  const std::string cube =
      "<body name='cube'><freejoint class='k'/><site name='pin'/><geom class='k' size='.1'/><body><geom "
      "size='1'/></body></body>\n";
  const std::string classes = "<default><default class='k'><geom magic='1'/></default></default>\n";
  const auto scene = [&](const std::string& body, const std::string& tail) {
    return "<mujoco>\n" + classes + "<worldbody>\n" + cube + body + "</worldbody>\n" + tail + "</mujoco>";
  };
  const std::string arm = std::string("<body name='b'><joint name='h'/>") + kBall + "</body>\n";
  const ImportedArm read =
      readText(scene(arm,
                     "<equality><weld body1='cube'/></equality>\n<tendon><spatial name='t'><site site='pin'/>"
                     "<site site='pin'/></spatial><spatial><site site='pin'/><site site='pin'/></spatial></tendon>\n"
                     "<actuator><motor tendon='t'/><motor joint='h'/></actuator>"));
  EXPECT_EQ(read.model.bodies.size(), 2U);
  EXPECT_EQ(read.model.tendons.size(), 1U) << "the motor of the hinge";
  EXPECT_TRUE(hasRemark(read.remarks, "body with a free joint", true, "robot.xml:4"));
  EXPECT_TRUE(hasRemark(read.remarks, "weld (equality)", true, "robot.xml:8"));
  EXPECT_TRUE(hasRemark(read.remarks, "spatial (tendon)", true, "robot.xml:9"));
  EXPECT_TRUE(hasRemark(read.remarks, "motor (actuator)", true, "robot.xml:10"));
  for (const ExchangeRemark& remark : read.remarks) EXPECT_NE(remark.what, "geom magic") << "of what is left out";
  // The robot itself may not float, alone or beside what hangs on the world.
  EXPECT_THAT(refusal(scene("", "")), HasSubstr("robot.xml:4: freejoint: found a floating base"));
  EXPECT_THAT(
      refusal(scene(
          arm + "<body><frame><joint type='free'/></frame>" + kBall + "<body><joint/>" + kBall + "</body></body>", "")),
      HasSubstr("joint: found a floating base"));
}

TEST(MjcfReader, AMeshNeedsNoInertialWhereItIsThere) {
  const std::string mesh = "<geom type='mesh' mesh='m'/>\n<geom type='capsule' mesh='m'/>\n";
  const std::string inertial = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>\n";
  EXPECT_TRUE(
      hasRemark(readText(robot("", "<joint/>\n" + mesh + inertial)).remarks, "mesh geom", false, "robot.xml:6"));
  EXPECT_TRUE(hasRemark(readText(robot("", "<joint/>\n" + mesh + kBall)).remarks, "mesh geom", true, "robot.xml:6"));
}

TEST(MjcfReader, SurfacesKeepTheirNamesOnTheWayThereAndBack) {
  const auto names = [](const ArmModel& arm) {
    std::vector<std::string> found;
    for (const Body& body : arm.bodies) {
      for (const Surface& surface : body.surfaces) found.push_back(surface.name);
    }
    return found;
  };
  const std::string line =
      "<tendon><spatial stiffness='1'><site site='a'/><geom geom='pg'/><site site='b'/></spatial></tendon>";
  ArmModel arm =
      readText(
          robot("",
                std::string("<joint/>\n<geom name='pg' size='.1' mass='0'/>\n<site name='a' pos='1 0 0'/>\n") + kBall,
                "<worldbody><site name='b' pos='0 1 0'/></worldbody>" + line))
          .model;
  arm = readText(writeMjcf(arm).text).model;
  EXPECT_EQ(names(arm), std::vector<std::string>{"pg"});
  // Geoms share their names: where two bodies have a surface of one name, each has its body's before it.
  arm.bodies[0].surfaces = arm.bodies[1].surfaces;
  EXPECT_THAT(writeMjcf(arm).text, HasSubstr("geom name=\"b/pg\""));
}

TEST(MjcfReader, MasslessBodiesKeepTheirNamesOnTheWayThereAndBack) {
  const auto names = [](const ArmModel& arm) {
    std::vector<std::string> found;
    for (const Body& body : arm.bodies) found.push_back(body.name);
    return found;
  };
  // Two joints of one body, and a body of its own that weighs nothing.
  const std::string arm = robot("", std::string("<joint/>\n<joint axis='1 0 0'/>\n") + kBall);
  EXPECT_EQ(names(readText(writeMjcf(readText(arm).model).text).model),
            (std::vector<std::string>{"world", "b_1", "b"}));
  const std::string bare = robot("", "<joint/>\n<body name='c'><joint axis='1 0 0'/>" + std::string(kBall) + "</body>");
  EXPECT_EQ(names(readText(writeMjcf(readText(bare).model).text).model), (std::vector<std::string>{"world", "b", "c"}));
}

TEST(MjcfReader, NamesTheLineOfAMissingIncludeAndTheFileWithoutJoints) {
  EXPECT_EQ(refusal("<mujoco>\n<include file='there.xml'/></mujoco>"),
            "robot.xml:2: include: file: there.xml was asked for");
  EXPECT_EQ(refusal("<mujoco/>"), "robot.xml: found no joint in the robot, expected at least one");
  EXPECT_THAT(refusal("<mujoco>\n<worldbody>\n<body name='\xFF'/></worldbody></mujoco>"),
              HasSubstr("robot.xml:3: body: found a text that is no UTF-8"));
}

TEST(MjcfReader, ReadsIncludesFromTheMainFilesFolder) {
  std::vector<std::string> asked;
  const FileReader read = [&](const std::filesystem::path& file) -> std::string {
    asked.push_back(file.string());
    if (asked.size() > 3) throw DataError("endless");
    return std::string("<mujocoinclude><body name='b'><joint/>") + kBall + "</body></mujocoinclude>";
  };
  const auto include = [](const std::string& file) {
    return "<mujoco><worldbody><include file='" + file + "'/></worldbody></mujoco>";
  };
  EXPECT_EQ(readMjcf(include("parts/b.xml"), "models/robot.xml", read).model.bodies[1].name, "b");
  // As MuJoCo's, from the main file's folder and out of it.
  EXPECT_EQ(readMjcf(include("parts/../../b.xml"), "models/robot.xml", read).model.bodies[1].name, "b");
  EXPECT_EQ(asked, (std::vector<std::string>{"models/parts/b.xml", "b.xml"}));
  EXPECT_THROW(readMjcf(include("/etc/passwd"), "models/robot.xml", read), DataError);
  EXPECT_EQ(asked.size(), 2U);
  const FileReader itself = [&](const std::filesystem::path&) {
    return "<mujocoinclude><include file='b.xml'/></mujocoinclude>";
  };
  EXPECT_THROW(readMjcf(include("b.xml"), "robot.xml", itself), DataError);
  // Includes nest what no file alone could: whatever it is, it ends with a sentence.
  const auto nested = [](const std::string& open, const std::string& close, const std::string& first) {
    int count = 0;
    const FileReader deeper = [&](const std::filesystem::path&) {
      std::string begin, end;
      for (int i = 0; i < 90; ++i) begin += open, end += close;
      return "<mujocoinclude>" + begin + fmt::format("<include file='{}.xml'/>", ++count) + end + "</mujocoinclude>";
    };
    return errorOf([&] { readMjcf("<mujoco>" + first + "</mujoco>", "robot.xml", deeper); });
  };
  EXPECT_THAT(nested("<body>", "</body>", "<worldbody><body><freejoint/><include file='b.xml'/></body></worldbody>"),
              HasSubstr("nested deeper than 500"));
  EXPECT_THAT(nested("<x>", "</x>", "<worldbody><x><include file='b.xml'/></x></worldbody>"),
              HasSubstr("nested deeper than 500"));
  // Another way to the same file is the same file.
  const FileReader round = [&](const std::filesystem::path&) {
    return "<mujocoinclude><include file='../models/./b.xml'/></mujocoinclude>";
  };
  EXPECT_THAT(errorOf([&] { readMjcf(include("b.xml"), "models/robot.xml", round); }), HasSubstr("a second time"));
}

}  // namespace
}  // namespace simgap::test
