#include "simgap/model/arm/parameter_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "simgap/core/error.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/files.h"

namespace simgap {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Choice = ParameterSpace::Choice;

ArmModel example() { return readArm(YamlNode::load(test::sourceFile("data/arm/arm.yaml"))); }

Choice choice(const std::string& pattern) { return {pattern, 0.5, {}, {}, {}, {}}; }

std::vector<std::string> namesOf(const std::vector<Choice>& choices) {
  std::vector<std::string> names;
  const ParameterSpace space(example(), choices);
  for (const SearchParameter& p : space.parameters()) names.push_back(p.name);
  return names;
}

std::string choiceError(const std::vector<Choice>& choices) {
  return test::errorOf([&] { ParameterSpace(example(), choices); });
}

/// All numbers of a model by name.
std::map<std::string, double> numbersOf(ArmModel model) {
  std::map<std::string, double> numbers;
  visitParameters(model, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    EXPECT_TRUE(numbers.emplace(path.str(), value).second) << path.str() << " is visited twice";
  });
  return numbers;
}

TEST(MatchesPattern, ComparesPartsByGlob) {
  EXPECT_TRUE(matchesPattern("muscles.biceps.spindle_radius_m", "muscles.biceps.spindle_radius_m"));
  EXPECT_TRUE(matchesPattern("muscles.*.spindle_radius_m", "muscles.biceps.spindle_radius_m"));
  EXPECT_TRUE(matchesPattern("muscles.*.attachments", "muscles.biceps.attachments.0.point_m.x"));
  EXPECT_TRUE(matchesPattern("*.*.*.*.*.x", "muscles.biceps.attachments.0.point_m.x"));
  EXPECT_FALSE(matchesPattern("muscles.*.spindle", "muscles.biceps.spindle_radius_m"));
  EXPECT_TRUE(matchesPattern("muscles.bi*.spindle_radius_m", "muscles.biceps.spindle_radius_m"));
  EXPECT_TRUE(matchesPattern("muscles.b*ps", "muscles.biceps.spindle_radius_m"));
  EXPECT_FALSE(matchesPattern("muscles.b*t", "muscles.biceps.spindle_radius_m"));
  EXPECT_FALSE(matchesPattern("muscles.*", "joints.elbow"));
  EXPECT_TRUE(matchesPattern("*.spindle_radius_m", "muscles.biceps.spindle_radius_m"));
  EXPECT_TRUE(matchesPattern("*.stiffness_N_m", "muscles.biceps.shock_cord.stiffness_N_m"));
  EXPECT_FALSE(matchesPattern("*.stiffness_N", "muscles.biceps.shock_cord.stiffness_N_m"));
  EXPECT_FALSE(matchesPattern("muscles.biceps.spindle_radius_m.x", "muscles.biceps.spindle_radius_m"));
  EXPECT_FALSE(matchesPattern("muscles..spindle_radius_m", "muscles.biceps.spindle_radius_m"));
}

TEST(ParameterSpace, TakesThePapers99ParametersInOneOrder) {
  const CalibrationConfig config =
      CalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_arm.yaml")));
  const std::vector<std::string> names = namesOf(config.parameters);
  ASSERT_EQ(names.size(), 99u);
  const std::string first = "muscles.deltoid_anterior.";
  EXPECT_THAT(
      std::vector(names.begin(), names.begin() + 9),
      ElementsAre(first + "attachments.0.point_m.x", first + "attachments.0.point_m.y",
                  first + "attachments.0.point_m.z", first + "attachments.1.point_m.x",
                  first + "attachments.1.point_m.y", first + "attachments.1.point_m.z", first + "kite_line_length_m",
                  first + "shock_cord.stiffness_N_m", first + "spindle_radius_m"));
  EXPECT_EQ(names.back(), "muscles.triceps.spindle_radius_m");
  // The order is the model's, whatever the order of the patterns.
  EXPECT_EQ(namesOf({config.parameters.rbegin(), config.parameters.rend()}), names);
  const ParameterSpace space(example(), config.parameters);
  const SearchParameter& stiffness = space.parameters()[7];
  EXPECT_EQ(stiffness.unit, "N_m");
  EXPECT_EQ(stiffness.initial, 900.0);
  EXPECT_EQ(stiffness.step, 25.0);
  EXPECT_EQ(stiffness.lower, 1.0);
  EXPECT_EQ(stiffness.upper, 1e4);
  ASSERT_TRUE(stiffness.prior_sd);
  EXPECT_NEAR(*stiffness.prior_sd, 117.0, 1e-12);  // 13 % of 900
  EXPECT_EQ(space.parameters()[0].prior_sd, 7e-3);
}

TEST(ParameterSpace, FindsSingleNumbersAndGroups) {
  EXPECT_THAT(namesOf({choice("muscles.biceps.spindle_radius_m")}), ElementsAre("muscles.biceps.spindle_radius_m"));
  EXPECT_THAT(namesOf({choice("joints.elbow.parent_position_m")}),
              ElementsAre("joints.elbow.parent_position_m.x", "joints.elbow.parent_position_m.y",
                          "joints.elbow.parent_position_m.z"));
  EXPECT_THAT(namesOf({choice("gravity_m_s2.z")}), ElementsAre("gravity_m_s2.z"));
  EXPECT_THAT(namesOf({choice("bodies.*.*.mass_kg")}),
              ElementsAre("bodies.humerus.bone.mass_kg", "bodies.humerus.actuators.mass_kg",
                          "bodies.forearm.bone.mass_kg", "bodies.forearm.fittings.mass_kg"));
  EXPECT_EQ(namesOf({choice("muscles.*.motor"), choice("muscles.*.gearbox")}).size(), 11u * (7 + 3));
}

TEST(ParameterSpace, RefusesPatternsThatMatchNothingOrTwice) {
  EXPECT_EQ(choiceError({choice("muscles.wing.attachments")}),
            "2: parameters: pattern 'muscles.wing.attachments' matches nothing in the model");
  EXPECT_EQ(choiceError({choice("muscles.*.spindle_radius_m"), choice("muscles.biceps")}),
            "2: parameters: muscles.biceps.spindle_radius_m is matched by both 'muscles.*.spindle_radius_m' and "
            "'muscles.biceps', expected one pattern");
  EXPECT_THAT(choiceError({choice("muscles"), choice("muscles")}),
              HasSubstr("is matched by both 'muscles' and 'muscles'"));
  // Both matches count as used: the double match is what is wrong.
  EXPECT_THAT(choiceError({choice("nothing"), choice("muscles"), choice("muscles.*")}),
              HasSubstr("is matched by both"));
}

TEST(ParameterSpace, APatternOfManyLeavesOutWhatTheModelDoesNotHave) {
  ArmModel model = example();
  ASSERT_GE(model.joints.size(), 2u);
  model.joints[0].coulomb_friction = 0.0;
  for (std::size_t j = 1; j < model.joints.size(); ++j) model.joints[j].coulomb_friction = 0.03;
  Choice friction = choice("joints.*.coulomb_friction_Nm");
  friction.lower = 1e-4;
  EXPECT_EQ(ParameterSpace(model, {friction}).parameters().size(), model.joints.size() - 1);
  friction.lower = 0.0;  // to 0 there is a way
  EXPECT_EQ(ParameterSpace(model, {friction}).parameters().size(), model.joints.size());
  friction = choice("joints." + model.joints[0].name + ".coulomb_friction_Nm");
  friction.lower = 1e-4;
  EXPECT_THROW(ParameterSpace(model, {friction}), ConfigError);
}

TEST(ParameterSpace, RefusesAnInitialValueOutsideItsRange) {
  Choice stiffness = choice("muscles.biceps.shock_cord.stiffness_N_m");  // 950 N/m
  stiffness.upper = 949.0;
  EXPECT_THAT(choiceError({stiffness}),
              AllOf(StartsWith("2: "), HasSubstr("muscles.biceps.shock_cord.stiffness_N_m is 950 N_m"),
                    HasSubstr("outside its range")));
  stiffness.upper = 950.0;
  stiffness.lower = 950.0;
  EXPECT_EQ(choiceError({stiffness}), "no error");
  stiffness.upper = 1e4;
  stiffness.lower = 950.1;
  EXPECT_THAT(choiceError({stiffness}), HasSubstr("outside its range"));
}

TEST(ParameterSpace, APercentageOfNothingIsNoPrior) {
  ArmModel model = example();
  model.joints[0].coulomb_friction = 0.0;
  Choice friction = choice("joints." + model.joints[0].name + ".coulomb_friction_Nm");
  friction.prior_sd_percent = 20.0;
  EXPECT_THROW(ParameterSpace(model, {friction}), ConfigError);
  model.joints[0].coulomb_friction = 0.05;
  EXPECT_NEAR(ParameterSpace(model, {friction}).parameters()[0].prior_sd.value(), 0.01, 1e-15);
}

TEST(ParameterSpace, ApplyTouchesOnlyTheChosen) {
  const ArmModel model = example();
  const ParameterSpace space(model, {choice("muscles.*.attachments.1"), choice("joints.elbow.viscous_friction_Nms"),
                                     choice("gravity_m_s2.y"), choice("bodies.forearm.bone.mass_kg")});
  std::vector<double> values;
  std::map<std::string, double> expected = numbersOf(model);
  for (const SearchParameter& p : space.parameters()) {
    values.push_back(1.0 + 0.125 * static_cast<double>(values.size()));
    expected.at(p.name) = values.back();
  }
  ArmModel changed = model;
  space.apply(values, changed);
  EXPECT_EQ(numbersOf(changed), expected);
  EXPECT_EQ(changed.bodies[2].parts[0].mass, expected.at("bodies.forearm.bone.mass_kg"));
}

TEST(ParameterSpace, ApplyingWhatWasReadChangesNothing) {
  const ArmModel model = example();
  const ParameterSpace space(model, {choice("muscles"), choice("joints"), choice("bodies"), choice("gravity_m_s2")});
  EXPECT_EQ(space.size(), numbersOf(model).size());
  std::vector<double> values;
  for (const SearchParameter& p : space.parameters()) values.push_back(p.initial);
  ArmModel same = model;
  space.apply(values, same);
  EXPECT_EQ(writeArm(same), writeArm(model));
}

TEST(ParameterChoices, RefusesBadEntriesWithTheirLine) {
  const auto error = [](const std::string& entry) {
    return test::errorOf([&] {
      const YamlNode root = YamlNode::parse("parameters:\n  - " + entry + "\n", "c.yaml");
      ParameterSpace::readChoices(root.at("parameters"));
      root.expectAllRead();
    });
  };
  EXPECT_EQ(error("{pattern: muscles, step: 1}"), "no error");
  EXPECT_THAT(error("{pattern: muscles}"), StartsWith("2: c.yaml:2: parameters[0]: "));
  EXPECT_THAT(error("{step: 1}"), StartsWith("2: c.yaml:2: parameters[0]: "));
  EXPECT_THAT(error("{pattern: '', step: 1}"), StartsWith("2: c.yaml:2: parameters[0].pattern: found an empty text"));
  EXPECT_THAT(error("{pattern: muscles, step: 0}"), StartsWith("2: c.yaml:2: parameters[0].step: found 0"));
  EXPECT_THAT(error("{pattern: muscles, step: -1}"), StartsWith("2: c.yaml:2: parameters[0].step: found -1"));
  EXPECT_THAT(error("{pattern: muscles, step: .nan}"), StartsWith("2: c.yaml:2: parameters[0].step: "));
  EXPECT_THAT(error("{pattern: muscles, step: 1, lower: 2, upper: 1}"), HasSubstr("lower 2 is above upper 1"));
  EXPECT_THAT(error("{pattern: muscles, step: 1, prior_sd: 0}"), HasSubstr("parameters[0].prior_sd: found 0"));
  EXPECT_THAT(error("{pattern: muscles, step: 1, prior_sd: 1, prior_sd_percent: 1}"), HasSubstr("found both prior_sd"));
  EXPECT_THAT(error("{pattern: muscles, step: 1, uper: 1}"), HasSubstr("parameters[0].uper: found an unknown key"));
}

}  // namespace
}  // namespace simgap
