#include "simgap/model/arm/arm_yaml.h"

#include <gtest/gtest.h>

#include <numbers>

#include "model/arm/small_arm.h"
#include "support/files.h"

namespace simgap {
namespace {

using test::kSmallArm;
using test::replaced;

ArmModel read(const std::string& text) { return readArm(YamlNode::parse(text, "a.yaml")); }

void expectSame(const ArmModel& a, const ArmModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.gravity, b.gravity);
  EXPECT_EQ(a.bodies, b.bodies);
  EXPECT_EQ(a.joints, b.joints);
  EXPECT_EQ(a.motor_defaults, b.motor_defaults);
  EXPECT_EQ(a.gearbox_defaults, b.gearbox_defaults);
  ASSERT_EQ(a.muscles.size(), b.muscles.size());
  for (std::size_t m = 0; m < a.muscles.size(); ++m) {
    const Muscle& x = a.muscles[m];
    const Muscle& y = b.muscles[m];
    EXPECT_EQ(x.name, y.name);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(x.attachments[i].body, y.attachments[i].body);
      EXPECT_EQ(x.attachments[i].point, y.attachments[i].point);
    }
    EXPECT_EQ(x.kite_line_length, y.kite_line_length);
    EXPECT_EQ(x.shock_cord.rest_length, y.shock_cord.rest_length);
    EXPECT_EQ(x.shock_cord.stiffness, y.shock_cord.stiffness);
    EXPECT_EQ(x.shock_cord.damping, y.shock_cord.damping);
    EXPECT_EQ(x.spindle_radius, y.spindle_radius);
    EXPECT_EQ(x.potentiometer_initial, y.potentiometer_initial);
    EXPECT_EQ(x.motor, y.motor) << x.name;
    EXPECT_EQ(x.gearbox, y.gearbox) << x.name;
  }
}

void expectRoundTrip(const std::string& text) {
  const ArmModel model = read(text);
  const std::string written = writeArm(model);
  SCOPED_TRACE(written);
  const ArmModel again = read(written);
  expectSame(model, again);
  EXPECT_EQ(writeArm(again), written);
}

TEST(ArmYaml, ReadsTheExampleAsItStands) {
  const ArmModel model = read(test::readText(test::sourceFile("data/arm/arm.yaml")));
  EXPECT_EQ(model.name, "anthropomimetic-arm");
  ASSERT_EQ(model.bodies.size(), 3u);
  EXPECT_TRUE(model.bodies[0].fixed);
  EXPECT_NEAR(massProperties(model.bodies[1]).mass, 0.31 + 0.74, 1e-15);
  ASSERT_EQ(model.joints.size(), 2u);
  EXPECT_EQ(model.joints[1].name, "elbow");
  EXPECT_EQ(model.joints[1].upper_limit, 2.3562);
  ASSERT_EQ(model.muscles.size(), 11u);
  EXPECT_EQ(model.muscles[8].name, "biceps");
  EXPECT_EQ(model.muscles[8].attachments[1].body, 2);
  EXPECT_EQ(model.muscles[8].attachments[1].point, Eigen::Vector3d(0.002, 0.026, -0.046));
  EXPECT_EQ(model.muscles[8].shock_cord.stiffness, 950.0);
  EXPECT_EQ(model.muscles[7].kite_line_length, -0.0199);
  EXPECT_EQ(model.muscles[0].motor, model.motor_defaults);
  EXPECT_EQ(model.muscles[0].gearbox.ratio, 72.0);
}

TEST(ArmYaml, ReadsEveryArmOfTheDataFolderAndWritesItBitByBit) {
  for (const char* name : {"arm", "arm-elbow", "arm-dense", "arm-hard"}) {
    SCOPED_TRACE(name);
    expectRoundTrip(test::readText(test::sourceFile(std::string("data/") + name + "/arm.yaml")));
  }
}

TEST(ArmYaml, ReadsPartsUnitsAndJointsInAnyOrder) {
  const ArmModel model = read(kSmallArm);
  EXPECT_EQ(model.joints[0].name, "shoulder");  // from the fixed body outwards
  const Joint& elbow = model.joints[1];
  EXPECT_EQ(elbow.lower_limit, -Joint::kUnlimited);
  EXPECT_NEAR(elbow.upper_limit, 0.75 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(elbow.axis.norm(), 1.0, 1e-15);
  EXPECT_EQ(elbow.coulomb_friction, 0.0);
  const Part& hand = model.bodies[2].parts[0];
  EXPECT_NEAR(hand.mass, 1100.0 * 4.0 / 3.0 * std::numbers::pi * 0.04 * 0.04 * 0.04, 1e-15);
  EXPECT_NEAR(model.bodies[2].parts[1].mass, 0.07, 1e-17);
  EXPECT_NEAR(model.muscles[0].motor.inductance, 3e-4, 1e-18);
  EXPECT_NEAR(model.muscles[0].potentiometer_initial, 33.3 * std::numbers::pi / 180.0, 1e-15);
}

TEST(ArmYaml, WritesVariantsBitByBit) {
  expectRoundTrip(kSmallArm);
  const std::string example = test::readText(test::sourceFile("data/arm/arm.yaml"));
  const std::string cord = "    shock_cord: {rest_length_m: 0.08, stiffness_N_m: 950, damping_Ns_m: 15}\n";
  expectRoundTrip(replaced(example, cord, cord + "    motor: {resistance_ohm: 0.9}\n    path: straight\n"));
  expectRoundTrip(replaced(example, cord, cord + "    gearbox: {efficiency: 1, ratio: 0.1}\n"));
  // A gearbox that does nothing but lose power.
  expectRoundTrip(replaced(example, "{ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5,",
                           "{ratio: 1, efficiency: 0.9, inertia_kg_m2: 0,"));
  // Axes whose length is not exactly 1 after division by it.
  for (const char* axis : {"[1, 1, 1]", "[0.3, 0.3, 0.1]", "[5, 7, 11]", "[1e-5, 2e-5, 1e-4]", "[0, 1, -1]"}) {
    expectRoundTrip(replaced(kSmallArm, "axis: [1, 2, 3]", std::string("axis: ") + axis));
    expectRoundTrip(replaced(kSmallArm, "mass_kg: 0.31,", std::string("mass_kg: 0.31, axis: ") + axis + ","));
  }
}

TEST(ArmYaml, WritesABranchingTreeBitByBit) {
  std::string text = replaced(
      kSmallArm, "joints:\n",
      R"(  - {name: finger, parts: [{name: f, shape: sphere, radius_m: 0.01, mass_kg: 0.1, position_m: [0, 0, 0]}]}
  - {name: thumb, parts: [{name: t, shape: sphere, radius_m: 0.01, mass_kg: 0.1, position_m: [0, 0, 0]}]}
  - {name: table, fixed: true}
joints:
  - {name: knuckle, type: revolute, parent: forearm, child: finger, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0], axis: [0, 1, 0]}
  - {name: ball, type: spherical, parent: forearm, child: thumb, parent_position_m: [0.1, 0, 0], child_position_m: [0, 0, 0], coulomb_friction_mNm: 20}
)");
  const ArmModel model = read(text);
  ASSERT_EQ(model.joints.size(), 4u);
  EXPECT_EQ(model.joints[0].name, "shoulder");
  EXPECT_EQ(model.joints[1].name, "elbow");
  EXPECT_NEAR(model.joints[3].coulomb_friction, 0.02, 1e-17);
  expectRoundTrip(text);
}

TEST(ArmYaml, WritesNamesThatYamlWouldTakeForSomethingElse) {
  for (const char* name : {"'null'", "'~'",       "'a: b'",    "'a #b'",  "'- a'",   "'{a'",  "'a}'", "'[a]'",
                           "'true'", "'12'",      "'1e3'",     "' a '",   "'\"a\"'", "'&a'",  "'@'",  "'%a'",
                           "'a\\b'", "\"a\\nb\"", "\"a\\tb\"", "'ärmel'", "'?'",     "'...'", "'---'"}) {
    SCOPED_TRACE(name);
    expectRoundTrip(replaced(kSmallArm, "name: small", std::string("name: ") + name));
    if (std::string_view(name) == "'...'") continue;  // a dot separates the parts of a path
    expectRoundTrip(replaced(kSmallArm, "name: biceps", std::string("name: ") + name));
    std::string renamed = kSmallArm;
    for (const char* key : {"name: ", "child: ", "parent: "}) {
      renamed = replaced(renamed, std::string(key) + "humerus", key + std::string(name));
    }
    expectRoundTrip(renamed);
  }
}

}  // namespace
}  // namespace simgap
