// Everything a model file can get wrong is one sentence with file, line and path, and exit code 2.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/arm/small_arm.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/files.h"

namespace simgap {
namespace {

using test::kSmallArm;
using test::replaced;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string errorOf(const std::string& text) {
  return test::errorOf([&] { readArm(YamlNode::parse(text, "a.yaml")); });
}
/// The error of the small arm with one text in it replaced.
std::string errorWith(std::string_view from, std::string_view to) { return errorOf(replaced(kSmallArm, from, to)); }

struct Case {
  const char* from;
  const char* to;
  const char* begin;      ///< of the sentence
  const char* rest = "";  ///< somewhere in it
};

void expectErrors(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    const std::string error = errorWith(c.from, c.to);
    EXPECT_THAT(error, AllOf(StartsWith(std::string("2: a.yaml:") + c.begin), HasSubstr(c.rest), Not(HasSubstr("\n"))))
        << "with '" << c.from << "' replaced by '" << c.to << "'";
  }
}

TEST(ArmYamlErrors, TheSmallArmItselfHasNone) { EXPECT_EQ(errorOf(kSmallArm), "no error"); }

TEST(ArmYamlErrors, NamesKeysThatAreMissingOrUnknown) {
  expectErrors({
      {"format: simgap/arm/1\n", "", "1: found only name, ", "expected the key 'format'"},
      {"format: simgap/arm/1", "format: simgap/arm/3",
       "1: format: found 'simgap/arm/3', expected one of simgap/arm/1, simgap/arm/2"},
      {"name: small\n", "", "1: ", "expected the key 'name'"},
      {"gravity_m_s2: [0, 0, -9.81]\n", "", "1: ", "gravity_m_s2"},
      {"name: small\n", "name: small\ncolour: red\n", "3: colour: found an unknown key"},
      {"length_m: 0.28, ", "", "8: bodies[1].parts[0]: ", "length_m"},
      {"shape: cylinder", "shape: cone", "8: bodies[1].parts[0].shape: found 'cone', expected one of sphere, cyl"},
      {"shape: sphere,", "shape: sphere, length_m: 1,", "11: bodies[2].parts[0].length_m: found an unknown key"},
      {"    spindle_radius_m: 0.006\n", "", "17: muscles[0]: ", "spindle_radius_m"},
      {", damping_Ns_m: 15", "", "20: muscles[0].shock_cord: ", "damping_Ns_m"},
      {"axis: [1, 2, 3], ", "", "14: joints[0]: ", "expected the key 'axis'"},
      {"parent_position_m: [0, 0, 0],", "", "15: joints[1]: ", "parent_position_m"},
      {"resistance_ohm: 0.8, ", "", "23: muscles[0].motor: ", "resistance_ohm"},
      {"ratio: 72, ", "", "24: muscles[0].gearbox: ", "ratio"},
      {"    motor:", "    moter:", "17: muscles[0]: 'motor' is missing"},
      {"    gearbox:", "    gear:", "17: muscles[0]: 'gearbox' is missing"},
      {"child_position_m: [0, 0, 0.01]", "child_position_m: [0, 0, 0.01], upper_limit_rad: 1",
       "15: joints[1].upper_limit_rad: found an unknown key"},
      {"    kite_line_length_m", "    path: wrapped\n    kite_line_length_m",
       "19: muscles[0].path: found 'wrapped', expected straight"},
  });
}

TEST(ArmYamlErrors, NamesUnitsThatDoNotFit) {
  expectErrors({
      {"radius_m: 0.018", "radius_furlong: 1", "8: bodies[1].parts[0].radius_furlong: unit 'furlong' does not exist"},
      {"stiffness_N_m", "stiffness_kg", "20: muscles[0].shock_cord.stiffness_kg: "},
      {"gravity_m_s2", "gravity_m_s", "3: gravity_m_s: "},
      {"upper_limit_deg", "upper_limit_m", "14: joints[0].upper_limit_m: "},
      {"mass_kg: 0.31", "mass_kg: 0.31, mass_g: 310", "8: bodies[1].parts[0].mass_g: found 'mass_kg' beside it"},
      {"mass_g: 70", "mass_g: 70, density_kg_m3: 3", "12: bodies[2].parts[1]: found both a mass and a density"},
      {"density_kg_m3: 1100, ", "", "11: bodies[2].parts[0]: ", "mass_kg"},
  });
}

TEST(ArmYamlErrors, NamesNumbersOutsideTheirRange) {
  expectErrors({
      {"mass_kg: 0.31", "mass_kg: 0", "8: bodies[1].parts[0].mass_kg: found 0, expected a number > 0"},
      {"mass_g: 70", "mass_g: -70", "12: bodies[2].parts[1].mass_g: found -70 (-0.07 kg), expected a number > 0"},
      {"density_kg_m3: 1100", "density_kg_m3: 0",
       "11: bodies[2].parts[0].density_kg_m3: found 0, expected a number > 0"},
      {"radius_m: 0.018", "radius_m: -0.018", "8: bodies[1].parts[0].radius_m: found -0.018, expected a number > 0"},
      {"size_m: [0.1, 0.02, 0.03]", "size_m: [0.1, 0, 0.03]",
       "12: bodies[2].parts[1]: size_m: expected three lengths > 0"},
      {"size_m: [0.1, 0.02, 0.03]", "size_m: [0.1, 0.02]", "12: bodies[2].parts[1].size_m: found a sequence of 2"},
      {"spindle_radius_m: 0.006", "spindle_radius_m: 0", "21: muscles[0].spindle_radius_m: found 0"},
      {"stiffness_N_m: 900", "stiffness_N_m: -1", "20: muscles[0].shock_cord.stiffness_N_m: found -1"},
      {"stiffness_N_m: 900", "stiffness_N_m: .nan", "20: muscles[0].shock_cord.stiffness_N_m: found '.nan'"},
      {"stiffness_N_m: 900", "stiffness_N_m: .inf", "20: muscles[0].shock_cord.stiffness_N_m: found '.inf'"},
      {"stiffness_N_m: 900", "stiffness_N_m: \"900\"", "20: muscles[0].shock_cord.stiffness_N_m: found the text '900'"},
      {"damping_Ns_m: 15", "damping_Ns_m: -0.1", "20: muscles[0].shock_cord.damping_Ns_m: found -0.1"},
      {"kite_line_length_m: 0.1", "kite_line_length_m: nan", "19: muscles[0].kite_line_length_m: found 'nan'"},
      {"[0, 0, -9.81]", "[0, 0, .nan]", "3: gravity_m_s2[2]: found '.nan'"},
      {"[0, 0, -9.81]", "-9.81", "3: gravity_m_s2: found -9.81, expected a sequence of three numbers"},
      {"axis: [1, 2, 3]", "axis: [0, 0, 0]", "14: joints[0].axis: found a zero vector"},
      {"efficiency: 0.72", "efficiency: 1.01",
       "24: muscles[0].gearbox.efficiency: found 1.01, expected a number in (0, 1]"},
      {"efficiency: 0.72", "efficiency: 0", "24: muscles[0].gearbox.efficiency: found 0, expected a number in (0, 1]"},
      {"ratio: 72", "ratio: 0", "24: muscles[0].gearbox.ratio: found 0"},
      {"resistance_ohm: 0.8", "resistance_ohm: 0", "23: muscles[0].motor.resistance_ohm: found 0"},
      {"fixed: true", "fixed: yes", "5: bodies[0].fixed: found 'yes', expected true or false"},
  });
  EXPECT_THAT(errorWith("upper_limit_deg: 135", "upper_limit_rad: 1, lower_limit_rad: 2"),
              StartsWith("2: a.yaml:14: joints[0]: lower_limit_rad 2 is above upper_limit_rad 1"));
  EXPECT_EQ(errorWith("upper_limit_deg: 135", "upper_limit_rad: 1, lower_limit_rad: 1"), "no error");
}

TEST(ArmYamlErrors, NamesBodiesThatHangNowhereOrTwice) {
  const char* const joints = "14: joints";
  expectErrors({
      {"parent: torso, child: humerus", "parent: forearm, child: humerus", joints, "hangs on a circle of joints"},
      {"parent: humerus, child: forearm", "parent: humerus, child: humerus", joints,
       "'humerus' is the child of two joints"},
      {"parent: humerus, child: forearm", "parent: forearm, child: forearm", joints,
       "'forearm' hangs on a circle of joints"},
      {"parent: humerus, child: forearm", "parent: humerus, child: torso", joints,
       "joint 'elbow' moves the fixed body 'torso'"},
      {"name: torso, fixed: true", "name: torso, fixed: false", "5: bodies[0]: a body that moves needs 'parts'"},
      {"joints:\n",
       "  - {name: loose, parts: [{name: a, shape: sphere, radius_m: 1, mass_kg: 1, position_m: [0, 0, "
       "0]}]}\njoints:\n",
       "15: joints", "body 'loose' is not connected to a fixed body by joints"},
      {"parent: torso", "parent: moon", "15: joints[1].parent: found 'moon', expected the name of a body"},
      {"child: forearm", "child: Forearm", "14: joints[0].child: found 'Forearm', expected the name of a body"},
  });
  const std::string before = kSmallArm.substr(0, kSmallArm.find("joints:"));
  EXPECT_THAT(errorOf(before + "joints: []\nmuscles: []\n"), StartsWith("2: a.yaml:13: joints: found no joint"));
  EXPECT_THAT(errorOf(before + "muscles: []\n"), HasSubstr("expected the key 'joints'"));
}

TEST(ArmYamlErrors, NamesBodiesWithoutParts) {
  const std::string part =
      "    parts:\n      - {name: bone, shape: cylinder, radius_m: 0.018, length_m: 0.28, mass_kg: 0.31, position_m: "
      "[0, "
      "0, -0.14]}\n";
  expectErrors({
      {part.c_str(), "    parts: []\n", "7: bodies[1].parts: found no part"},
      {part.c_str(), "", "6: bodies[1]: a body that moves needs 'parts'"},
      {part.c_str(), "    parts: 3\n", "7: bodies[1].parts: found 3, expected a sequence"},
  });
}

TEST(ArmYamlErrors, NamesMusclesThatAreAttachedWrongly) {
  expectErrors({
      {"{body: forearm,", "{body: wing,",
       "18: muscles[0].attachments[1].body: found 'wing', expected the name of a body"},
      {"{body: forearm,", "{body: torso,", "18: muscles[0].attachments: both ends are on the same body"},
      {"{body: torso, point_m: [0.01, 0.07, 0.05]}, {body: forearm, point_m: [0, 0.02, -0.1]}",
       "{body: humerus, point_m: [0, 0, -0.28]}, {body: forearm, point_m: [0, 0, 0]}",
       "18: muscles[0].attachments: found a line without length at any position of the joints"},
      {", {body: forearm, point_m: [0, 0.02, -0.1]}]", "]",
       "18: muscles[0].attachments: found 1 attachments, expected 2"},
      {"[0, 0.02, -0.1]", "[0, 0.02]", "18: muscles[0].attachments[1].point_m: found a sequence of 2"},
  });
}

TEST(ArmYamlErrors, NamesNamesThatStandTwiceOrCannotBeNames) {
  expectErrors({
      {"name: forearm", "name: humerus", "9: bodies[2].name: the name 'humerus' is taken"},
      {"name: plate", "name: hand", "12: bodies[2].parts[1].name: the name 'hand' is taken"},
      {"name: shoulder", "name: elbow", "15: joints[1].name: the name 'elbow' is taken"},
      {"name: biceps", "name: bi.ceps", "17: muscles[0].name: found 'bi.ceps', expected a name without '.'"},
      {"name: biceps", "name: 'b*'", "17: muscles[0].name: found 'b*'"},
      {"name: biceps", "name: 'b,c'", "17: muscles[0].name: found 'b,c'"},
      {"name: biceps", "name: ''", "17: muscles[0].name: found ''"},
      {"name: biceps", "name: [a]", "17: muscles[0].name: found a sequence, expected a text"},
  });
  const std::string muscle = kSmallArm.substr(kSmallArm.find("  - name: biceps"));
  EXPECT_THAT(errorOf(kSmallArm + muscle), StartsWith("2: a.yaml:25: muscles[1].name: the name 'biceps' is taken"));
}

TEST(ArmYamlErrors, NamesAnEffectNobodyKnows) {
  EXPECT_THAT(errorOf(kSmallArm + "extensions:\n  - {effect: magic, parameters: {}}\n"),
              StartsWith("2: a.yaml:26: extensions[0].effect: found 'magic'"));
  EXPECT_EQ(errorOf(kSmallArm + "extensions: []\n"), "no error");
}

TEST(ArmYamlErrors, RefusesWhatIsNoModelAtAll) {
  for (const char* text : {"", "[]", "3", "a: b: c", "{", "format: simgap/arm/1\n---\nb: 1\n"}) {
    EXPECT_THAT(errorOf(text), StartsWith("2: a.yaml:")) << text;
  }
  EXPECT_THAT(errorOf(kSmallArm + "name: again\n"), StartsWith("2: a.yaml:25: name: found the key twice"));
}

}  // namespace
}  // namespace simgap
