// What an MJCF file must not say: words that MuJoCo does not know, masses that nobody has stated, and in which words
// and at which place a reader of the file is told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mjcf_texts.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

std::string turning(const std::string& attributes = "") { return "<joint name='h'" + attributes + "/>\n" + kBall; }

TEST(MjcfRefusals, AKeywordOrNameThatMuJoCoDoesNotKnowIsRefused) {
  const auto actuator = [](const std::string& said) {
    return robot("", turning(), "<actuator><general joint='h' " + said + "/></actuator>\n");
  };
  const std::vector<std::pair<std::string, std::string>> refused = {
      {robot("<compiler angle='radians'/>\n", turning()),
       "robot.xml:2: compiler: angle: found 'radians', expected degree, radian"},
      {robot("<compiler angle='Degree'/>\n", turning()), "found 'Degree', expected degree, radian"},
      {robot("<compiler inertiafromgeom='yes'/>\n", turning()),
       "inertiafromgeom: found 'yes', expected false, true, auto"},
      {robot("<compiler autolimits='1'/>\n", turning()), "autolimits: found '1', expected false, true"},
      {robot("<option><flag gravity='off'/></option>\n", turning()), "gravity: found 'off', expected enable, disable"},
      {robot("", turning(" type='Hinge'")),
       "robot.xml:4: joint: type: found 'Hinge', expected free, ball, slide, hinge"},
      {robot("<default><joint type='revolute'/></default>\n", turning()), "robot.xml:2: joint: type: found 'revolute'"},
      {robot("", turning(" limited='yes'")), "limited: found 'yes', expected false, true, auto"},
      {robot("", turning() + "<geom type='cube' size='1 1 1'/>\n"), "robot.xml:6: geom: type: found 'cube', expected"},
      {robot("", turning() + "<site type='point'/>\n"), "site: type: found 'point', expected sphere"},
      {robot("", turning(), "<contact><exclude body1='world' body2='arm'/></contact>\n"),
       "exclude: body2: found 'arm', expected the name of a body"},
      {robot("", turning(), "<contact><pair geom1='g' geom2='f'/></contact>\n"),
       "pair: geom1: found 'g', expected the name of a geom"},
      {actuator("gaintype='Fixed'"), "general: gaintype: found 'Fixed', expected fixed, affine, muscle, user"},
      {actuator("biastype='afine'"), "biastype: found 'afine', expected none, affine, muscle, user"},
      {actuator("dyntype='filters'"), "dyntype: found 'filters', expected none, integrator, filter"},
  };
  for (const auto& [text, sentence] : refused) EXPECT_THAT(refusal(text), HasSubstr(sentence));
  readText(robot("<compiler angle='radian' inertiafromgeom='auto'/>\n", turning(" type='hinge' limited='auto'")));
}

TEST(MjcfRefusals, ABoundOrATotalIsNoMassOfAMesh) {
  const std::string mesh = "<joint/>\n<geom type='mesh' mesh='m'/>\n";
  EXPECT_THAT(refusal(robot("<compiler settotalmass='2'/>\n", mesh + kBall)),
              HasSubstr("robot.xml:6: geom: found a mesh, which is not read, where the compiler's settotalmass"));
  EXPECT_THAT(refusal(robot("<compiler boundmass='0.1'/>\n", mesh)), HasSubstr("would weigh the compiler's boundmass"));
  // A stated mass asks no mesh, one of other geoms is above the bound.
  readText(
      robot("<compiler settotalmass='2'/>\n", mesh + "<inertial pos='0 0 0' mass='1' diaginertia='0.1 0.1 0.1'/>\n"));
  EXPECT_TRUE(hasRemark(readText(robot("<compiler boundmass='0.1'/>\n", mesh + kBall)).remarks, "mesh geom", true,
                        "robot.xml:6"));
}

TEST(MjcfRefusals, WhatTheArmCannotBeIsSaidAtItsPlaceInTheFile) {
  const std::string flat = "<inertial pos='0 0 0' mass='1' diaginertia='0.1 0.2 9'/>\n";
  EXPECT_THAT(refusal(robot("", "<joint/>\n" + flat)), HasSubstr("robot.xml:3: body 'b': inertia_kg_m2: found"));
  EXPECT_THAT(refusal(robot("", turning() + "<body name='lid'>\n" + flat + "</body>\n")),
              HasSubstr("robot.xml:6: body 'lid': inertia_kg_m2: found"));
  EXPECT_THAT(refusal(robot("", "<joint/>\n")), HasSubstr("robot.xml:3: body 'b' moves without any mass"));
  EXPECT_THAT(refusal(robot("", turning() + "<site name='to'/>\n",
                            "<worldbody><site name='in'/></worldbody>\n<tendon>\n<spatial name='s'><site site='in'/>"
                            "<site site='to'/></spatial></tendon>\n")),
              HasSubstr("robot.xml:11: tendon 's': attachments: found a line without length"));
}

TEST(MjcfRefusals, BodiesThatOnlyMujocoMakesAreNamed) {
  const std::string copies = "<replicate count='3'><body><joint/>" + std::string(kBall) + "</body></replicate>\n";
  EXPECT_THAT(refusal("<mujoco>\n<worldbody>\n" + copies + "</worldbody></mujoco>"),
              HasSubstr("robot.xml:3: replicate: found it, which is not read, and no joint outside of it"));
  EXPECT_TRUE(hasRemark(readText(robot("", turning(), "<worldbody>\n" + copies + "</worldbody>\n")).remarks,
                        "replicate", true, "robot.xml:9"))
      << "beside a robot they are left out";
}

TEST(MjcfRefusals, ElementsMayStandOnlySoDeep) {
  std::string deep = "<mujoco><worldbody>\n";
  for (int i = 0; i < 120; ++i) deep += "<body>\n";
  EXPECT_THAT(refusal(deep), HasSubstr("found elements nested deeper than 100, the most that can be read of one file"));
}

TEST(MjcfRemarks, TellFilesOfOneNameApart) {
  const FileReader read = [](const std::filesystem::path& file) {
    return "<mujocoinclude><body name='" + file.parent_path().filename().string() + "'><joint magic='1'/>" + kBall +
           "</body></mujocoinclude>";
  };
  const ImportedArm arm =
      readMjcf("<mujoco><worldbody><include file='a/part.xml'/><include file='b/part.xml'/></worldbody></mujoco>",
               "robot.xml", read);
  EXPECT_TRUE(hasRemark(arm.remarks, "joint magic", true, "a/part.xml:1"));
  EXPECT_TRUE(hasRemark(arm.remarks, "joint magic", true, "b/part.xml:1"));
}

TEST(MjcfRemarks, SayWhatWasDone) {
  const auto remark = [](const std::string& text, const std::string& what) {
    for (const ExchangeRemark& r : readText(text).remarks) {
      if (r.what == what) return r.done;
    }
    return std::string("nothing was said");
  };
  const std::string two = turning() + "<joint name='k' axis='0 1 0'/>\n";
  EXPECT_THAT(remark(robot("", two, "<equality><joint joint1='k' joint2='h' polycoef='0 1 2'/></equality>"),
                     "joint (equality) along a curve (polycoef)"),
              HasSubstr("the whole coupling is left out"));
  EXPECT_THAT(
      remark(robot("", two, "<equality><joint joint1='k' joint2='h' solref='0.01 1'/></equality>"), "joint solref"),
      HasSubstr("couplings hold exactly here"));
  EXPECT_THAT(remark(robot("", turning() + "<geom size='1' fluidshape='ellipsoid'/>\n"), "geom fluidshape"),
              HasSubstr("no air and no liquid acts on bodies"));
  EXPECT_THAT(remark(robot("", turning(" type='ball' range='0 1' limited='true'")), "joint range of a ball"),
              HasSubstr("it limits the whole turn in MuJoCo"));
  EXPECT_THAT(remark(robot("", turning() + "<site name='in' pos='0.1 0 0'/>\n",
                           "<worldbody><site name='out'/></worldbody><tendon><spatial name='s'><site site='in'/>"
                           "<site site='out'/></spatial></tendon><actuator><general tendon='s' biastype='affine' "
                           "gainprm='0' biasprm='1 -50 0'/></actuator>"),
                     "general (actuator of a tendon)"),
              HasSubstr("a muscle that its control does not move (its gain is 0)"));
}

// Stiffness and damping are those that MuJoCo 3.3 makes of the same text.
TEST(MjcfSprings, ASpringDamperIsWorkedOutAsThere) {
  const ArmModel chain =
      readText(
          std::string(
              "<mujoco><worldbody><body pos='0 0 1'><joint name='a' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 "
              "0.3 0 "
              "0' size='0.02' mass='1'/><body pos='0.3 0 0'><joint name='b' axis='0 1 0' springdamper='0.3 1' "
              "armature='0.01' stiffness='7'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' mass='1'/></body>"
              "</body></worldbody></mujoco>"))
          .model;
  EXPECT_EQ(chain.joints[0].spring_stiffness, 0.0);
  EXPECT_NEAR(chain.joints[1].spring_stiffness, 0.19360103349115407, 1e-12);
  EXPECT_NEAR(chain.joints[1].viscous_friction, 0.11616062009469244, 1e-12);
  const ArmModel mixed =
      readText(
          std::string(
              "<mujoco><worldbody><body pos='0 0 1' euler='10 20 30'><joint name='a' type='slide' axis='0 1 1' "
              "springdamper='0.2 0.5'/><geom type='box' size='0.1 0.2 0.3' mass='1'/><body pos='0.3 0 0'><joint "
              "name='b' "
              "type='ball' pos='0 0.1 0' springdamper='0.3 1'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02' "
              "mass='1'/></body></body></worldbody></mujoco>"))
          .model;
  EXPECT_NEAR(mixed.joints[0].spring_stiffness, 123.82046071202011, 1e-9);
  EXPECT_NEAR(mixed.joints[0].viscous_friction, 12.382046071202012, 1e-9);
  EXPECT_NEAR(mixed.joints[1].spring_stiffness, 0.0669698232249184, 1e-12);
  EXPECT_NEAR(mixed.joints[1].viscous_friction, 0.040181893934951037, 1e-12);
}

}  // namespace
}  // namespace simgap::test
