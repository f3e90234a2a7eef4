#include "simgap/fit/actuators/parameter_choices.h"

#include <gtest/gtest.h>

#include "simgap/core/error.h"
#include "support/files.h"

namespace simgap {
namespace {

using Texts = std::vector<std::string>;

ParameterChoices read(const Texts& fix, const Texts& bounds) { return readParameterChoices(fix, bounds); }

TEST(ParameterChoicesTest, ReadsValuesAndBounds) {
  const ParameterChoices choices = read({"k_a=1.3", "R=2e-1"}, {"k_v=-1:5"});
  EXPECT_EQ(choices.fixed.at("k_a"), 1.3);
  EXPECT_EQ(choices.fixed.at("R"), 0.2);
  EXPECT_EQ(choices.bounds.at("k_v").lower, -1.0);
  EXPECT_EQ(choices.bounds.at("k_v").upper, 5.0);
}

TEST(ParameterChoicesTest, RefusesWhatIsNoEntry) {
  for (const char* text : {"k_a", "=1", "k_a=", "k_a=one"}) EXPECT_THROW(read({text}, {}), ConfigError) << text;
  for (const char* text : {"k_v=1", "k_v=1:2:3", "k_v=3:1", "k_v=1:1", "k_v=a:b"}) {
    EXPECT_THROW(read({}, {text}), ConfigError) << text;
  }
}

TEST(ParameterChoicesTest, RefusesParametersThatNoModelHas) {
  const Texts known{"k_a", "k_v", "k_a"};
  EXPECT_NO_THROW(requireKnown(read({"k_a=1"}, {"k_v=0:1"}), known));
  EXPECT_THROW(requireKnown(read({"k_z=1"}, {}), known), ConfigError);
  try {
    requireKnown(read({}, {"k_z=0:1"}), known);
    FAIL() << "k_z was taken";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "--bounds: found the parameter k_z, expected one of k_a, k_v");
  }
}

TEST(ParameterChoicesTest, ConstrainsSpecificationsAndFixesValues) {
  std::vector<ParameterSpec> specs = {{"a", "1"}, {"b", "1", 0.0, 9.0}, {"c", "1", 0.0, 1.0, /*fixed=*/true}};
  const ParameterChoices choices = read({"a=3"}, {"b=2:4"});
  constrain(choices, specs);
  EXPECT_TRUE(specs[0].fixed);
  EXPECT_FALSE(specs[1].fixed);
  EXPECT_EQ(specs[1].lower, 2.0);
  EXPECT_EQ(specs[1].upper, 4.0);
  EXPECT_TRUE(specs[2].fixed);
  std::vector<double> theta = {1.0, 2.0, 0.5};
  fixValues(specs, choices.fixed, theta);
  EXPECT_EQ(theta, (std::vector<double>{3.0, 2.0, 0.5}));
}

TEST(ParameterChoicesTest, RefusesANameThatStandsTwice) {
  EXPECT_THROW(read({"R=1", "R=2"}, {}), ConfigError);
  EXPECT_THROW(read({}, {"R=1:2", "R=1:3"}), ConfigError);
  EXPECT_THROW(read({"R=1"}, {"R=0.5:2"}), ConfigError);
}

/// What is said of a choice for a resistance, a friction, an efficiency and an offset.
std::string saidOf(const Texts& fix, const Texts& bounds) {
  std::vector<ParameterSpec> specs = {
      {"R", "ohm", 1e-12}, {"mu", "Nms", 0.0}, {"eta", "1", 1e-3, 1.0}, {"offset", "A"}};
  return test::errorOf([&] { constrain(read(fix, bounds), specs); });
}

TEST(ParameterChoicesTest, RefusesWhatAParameterCannotBe) {
  EXPECT_EQ(saidOf({"R=-1"}, {}), "2: --fix R: found -1, expected a number > 0");
  EXPECT_EQ(saidOf({"R=0"}, {}), "2: --fix R: found 0, expected a number > 0");
  EXPECT_EQ(saidOf({"mu=-2"}, {}), "2: --fix mu: found -2, expected a number >= 0");
  EXPECT_EQ(saidOf({"eta=1.2"}, {}), "2: --fix eta: found 1.2, expected a number in (0, 1]");
  EXPECT_EQ(saidOf({}, {"R=-2:-1"}), "2: --bounds R: found -2:-1, expected each to be a number > 0");
  EXPECT_EQ(saidOf({}, {"mu=-1:5"}), "2: --bounds mu: found -1:5, expected each to be a number >= 0");
  EXPECT_EQ(saidOf({}, {"eta=0.5:1.5"}), "2: --bounds eta: found 0.5:1.5, expected each to be a number in (0, 1]");
}

TEST(ParameterChoicesTest, TakesWhatAParameterCanBe) {
  std::vector<ParameterSpec> specs = {
      {"R", "ohm", 1e-12}, {"mu", "Nms", 0.0}, {"eta", "1", 1e-3, 1.0}, {"offset", "A"}};
  EXPECT_NO_THROW(constrain(read({"mu=0", "eta=1", "offset=-3"}, {"R=0:2"}), specs));
  EXPECT_GT(specs[0].lower, 0.0);  // a resistance of nothing divides by it
  EXPECT_EQ(specs[0].upper, 2.0);
}

}  // namespace
}  // namespace simgap
