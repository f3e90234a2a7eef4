// Names: a given one stays where it was given, and what becomes of it otherwise is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mjcf_texts.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

std::string calledHere(const ImportedArm& read, const std::string& what) {
  for (const ExchangeRemark& remark : read.remarks) {
    if (remark.what == what && !remark.matters) return remark.done;
  }
  return "nothing was said";
}

template <typename T>
std::vector<std::string> namesOf(const std::vector<T>& things) {
  std::vector<std::string> names;
  for (const T& thing : things) names.push_back(thing.name);
  return names;
}

using Names = std::vector<std::string>;

TEST(Names, AMadeUpOneTakesNoGivenOne) {
  const std::string ball = kBall;
  const ImportedArm read =
      readText("<mujoco><worldbody>\n<body><joint/>" + ball + "<body name='body_1'><joint name='elbow.l'/>" + ball +
               "<body><joint name='elbow_l'/>" + ball + "</body></body></body></worldbody></mujoco>");
  EXPECT_EQ(namesOf(read.model.bodies), (Names{"world", "body_1_2", "body_1", "body_3"}));
  EXPECT_EQ(namesOf(read.model.joints), (Names{"body_1_2_joint", "elbow_l_2", "elbow_l"}));
  EXPECT_EQ(calledHere(read, "joint 'elbow.l'"), "called 'elbow_l_2' here: names hold neither '.' nor '*' nor ','");
  EXPECT_EQ(calledHere(read, "body ''"), "nothing was said");
}

TEST(Names, LinesAndDrivesShareTheirs) {
  const auto line = [](const std::string& attributes) {
    return "<spatial " + attributes + "><site site='in'/><site site='out'/></spatial>\n";
  };
  const ImportedArm read = readText(
      robot("", "<joint name='elbow'/>\n" + std::string(kBall) + "<site name='in' pos='0.1 0 0'/>\n",
            "<worldbody><site name='out' pos='0 1 0'/></worldbody>\n<tendon>\n" + line("stiffness='5'") +
                line("name='t' stiffness='3'") + line("name='t_2'") + line("name='elbow'") + line("name='tendon'") +
                "</tendon>\n<actuator>\n<motor name='pull' tendon='t'/>\n<motor name='elbow' tendon='elbow'/>\n"
                "<position name='elbow.' joint='elbow' kp='3'/>\n<motor joint='elbow'/>\n</actuator>\n"));
  EXPECT_EQ(namesOf(read.model.muscles), (Names{"t", "elbow"}));
  EXPECT_EQ(namesOf(read.model.tendons), (Names{"tendon_2", "t_3", "t_2", "tendon", "elbow_", "elbow_2"}));
  EXPECT_EQ(calledHere(read, "actuator 'pull'"), "called 't' here, as the tendon that it acts on");
  EXPECT_EQ(calledHere(read, "actuator 'elbow'"), "nothing was said");
  EXPECT_THAT(calledHere(read, "actuator 'elbow.'"), HasSubstr("called 'elbow_' here"));
  const ImportedArm taken =
      readText(robot("", "<joint name='elbow'/>\n" + std::string(kBall) + "<site name='in' pos='0.1 0 0'/>\n",
                     "<worldbody><site name='out' pos='0 1 0'/></worldbody>\n<tendon>\n" + line("name='elbow'") +
                         "</tendon>\n<actuator><position name='elbow' joint='elbow' kp='3'/></actuator>\n"));
  EXPECT_EQ(namesOf(taken.model.tendons), (Names{"elbow", "elbow_2"}));
  EXPECT_EQ(calledHere(taken, "actuator 'elbow'"), "called 'elbow_2' here: the name is taken");
}

/// Two surfaces of one body whose names our files hold alike stay two: the line runs over both.
TEST(Names, OfSurfacesStayApart) {
  const std::string line =
      "<spatial name='line' stiffness='5'><site site='in'/><geom geom='s.1'/><site site='mid'/><geom geom='s_1'/>"
      "<site site='out'/></spatial>";
  const ImportedArm read =
      readText(robot("", "<joint name='elbow'/>\n" + std::string(kBall) + "<site name='in' pos='0.3 0 0'/>\n",
                     "<worldbody><geom name='s.1' size='0.05' mass='0' pos='1 0 0'/>"
                     "<geom name='s_1' size='0.07' mass='0' pos='1 2 0'/><geom name='other.1' size='0.01' mass='0'/>"
                     "<site name='mid' pos='1 1 0'/><site name='out' pos='0 3 0'/></worldbody>\n<tendon>\n" +
                         line + "</tendon>\n"));
  const std::vector<Surface>& surfaces = read.model.bodies[0].surfaces;
  ASSERT_EQ(namesOf(surfaces), (Names{"s_1_2", "s_1"}));
  EXPECT_DOUBLE_EQ(surfaces[0].radius, 0.05);
  EXPECT_DOUBLE_EQ(surfaces[1].radius, 0.07);
  EXPECT_THAT(calledHere(read, "geom 's.1'"), HasSubstr("called 's_1_2' here"));
  EXPECT_EQ(calledHere(read, "geom 'other.1'"), "nothing was said") << "no line runs over it";
}

TEST(Names, OfLinksAndTheirJointsAreRemarkedToo) {
  const std::string mass = "<inertial><mass value='1'/><inertia ixx='.01' iyy='.01' izz='.01'/></inertial>";
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child,
                        const std::string& more) {
    return "<joint name='" + name + "' type='continuous'><parent link='" + parent + "'/><child link='" + child + "'/>" +
           more + "</joint>";
  };
  const ImportedArm read =
      readUrdf("<robot name='r'><link name='world'/><link name='l.1'>" + mass + "</link><link name='l_1'>" + mass +
                   "</link>" + joint("j.1", "world", "l.1", "") +
                   joint("k", "l.1", "l_1", "<mimic joint='j.1' multiplier='2'/>") + "</robot>",
               "robot.urdf");
  EXPECT_EQ(namesOf(read.model.bodies), (Names{"world", "l_1_2", "l_1"}));
  EXPECT_EQ(namesOf(read.model.joints), (Names{"j_1", "k"}));
  EXPECT_EQ(read.model.joints[1].leader, 0);
  EXPECT_THAT(calledHere(read, "link 'l.1'"), HasSubstr("called 'l_1_2' here"));
  EXPECT_THAT(calledHere(read, "joint 'j.1'"), HasSubstr("called 'j_1' here"));
}

}  // namespace
}  // namespace simgap::test
