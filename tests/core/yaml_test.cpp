#include "simgap/core/yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "simgap/core/error.h"

namespace simgap {
namespace {

using ::testing::ElementsAre;

YamlNode parseYaml(const std::string& text) { return YamlNode::parse(text, "f.yaml"); }

/// The sentence of the ConfigError that `read` throws.
std::string yamlSentence(const std::function<void()>& read) {
  try {
    read();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

std::string yamlSentence(const std::string& text, const std::function<void(const YamlNode&)>& read) {
  return yamlSentence([&] { read(parseYaml(text)); });
}

/// The sentence about the value of the key `x` on line 1.
std::string numberSentence(const std::string& value, const Range& range = kAnyNumber) {
  return yamlSentence("x: " + value, [&](const YamlNode& root) { root.at("x").number(range); });
}

TEST(Yaml, ReadsMapsSequencesAndScalars) {
  const YamlNode root =
      parseYaml("name: biceps\nfixed: true\ncount: 3\npoint: [1, -2.5, 1e-3]\nparts:\n  - {a: 1}\n  - 2\n");
  EXPECT_EQ(root.at("name").text(), "biceps");
  EXPECT_TRUE(root.at("fixed").boolean());
  EXPECT_EQ(root.at("count").integer(1, 5), 3);
  EXPECT_EQ(root.at("point").vector3(), Eigen::Vector3d(1.0, -2.5, 1e-3));
  const std::vector<YamlNode> parts = root.at("parts").items();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_TRUE(root.isMap() && parts[0].isMap() && parts[1].isScalar() && root.at("point").isSequence());
  EXPECT_EQ(parts[0].at("a").path(), "parts[0].a");
  EXPECT_THAT(root.keys(), ElementsAre("name", "fixed", "count", "point", "parts"));
  EXPECT_TRUE(root.has("name"));
  EXPECT_FALSE(root.has("nose"));
  EXPECT_FALSE(root.find("nose"));
  root.expectAllRead();
}

TEST(Yaml, TakesNumbersInPlainDecimalAndScientificNotationOnly) {
  EXPECT_EQ(parseYaml("x: 1e3").at("x").number(), 1000.0);
  EXPECT_EQ(parseYaml("x: +5").at("x").number(), 5.0);
  EXPECT_EQ(parseYaml("x: 010").at("x").number(), 10.0);
  EXPECT_EQ(numberSentence("0x10"), "f.yaml:1: x: found '0x10', expected a finite number");
  EXPECT_EQ(numberSentence("1_000"), "f.yaml:1: x: found '1_000', expected a finite number");
  EXPECT_EQ(numberSentence("1:30"), "f.yaml:1: x: found '1:30', expected a finite number");
  EXPECT_EQ(numberSentence(".nan"), "f.yaml:1: x: found '.nan', expected a finite number");
  EXPECT_EQ(numberSentence(".inf"), "f.yaml:1: x: found '.inf', expected a finite number");
  EXPECT_EQ(numberSentence("1e999"), "f.yaml:1: x: found '1e999', expected a finite number");
  EXPECT_EQ(numberSentence("abc"), "f.yaml:1: x: found 'abc', expected a finite number");
  EXPECT_EQ(numberSentence("\"5\""), "f.yaml:1: x: found the text '5', expected a finite number");
  EXPECT_EQ(numberSentence("!!str 5"), "f.yaml:1: x: found the text '5', expected a finite number");
  EXPECT_EQ(numberSentence(""), "f.yaml:1: x: found nothing, expected a finite number");
  EXPECT_EQ(numberSentence("[1]"), "f.yaml:1: x: found a sequence, expected a finite number");
  EXPECT_EQ(numberSentence("{a: 1}"), "f.yaml:1: x: found a map, expected a finite number");
}

TEST(Yaml, KeepsNumbersInsideTheirRange) {
  EXPECT_EQ(parseYaml("x: 0").at("x").number(kNonNegative), 0.0);
  EXPECT_EQ(numberSentence("0", kPositive), "f.yaml:1: x: found 0, expected a number > 0");
  EXPECT_EQ(numberSentence("-1", kNonNegative), "f.yaml:1: x: found -1, expected a number >= 0");
  const Range fraction{0.0, 1.0, false, "a number from 0 to 1"};
  EXPECT_EQ(parseYaml("x: 1").at("x").number(fraction), 1.0);
  EXPECT_EQ(numberSentence("1.5", fraction), "f.yaml:1: x: found 1.5, expected a number from 0 to 1");
}

TEST(Yaml, TakesIntegersAndSeedsAsIntegersOnly) {
  const auto integerSentence = [](const std::string& value, long upper) {
    return yamlSentence("x: " + value, [&](const YamlNode& root) { root.at("x").integer(1, upper); });
  };
  constexpr long kNoLimit = std::numeric_limits<long>::max();
  EXPECT_EQ(parseYaml("x: -5").at("x").integer(-5, 5), -5);
  EXPECT_EQ(parseYaml("x: +5").at("x").integer(1, 5), 5);
  EXPECT_EQ(integerSentence("6", 5), "f.yaml:1: x: found 6, expected an integer from 1 to 5");
  EXPECT_EQ(integerSentence("0", kNoLimit), "f.yaml:1: x: found 0, expected an integer >= 1");
  EXPECT_EQ(integerSentence("2.5", 5), "f.yaml:1: x: found 2.5, expected an integer from 1 to 5");
  EXPECT_EQ(integerSentence("9999999999999999999", kNoLimit),
            "f.yaml:1: x: found 9999999999999999999, expected an integer >= 1");
  EXPECT_EQ(integerSentence("'3'", 5), "f.yaml:1: x: found the text '3', expected an integer from 1 to 5");
  EXPECT_EQ(parseYaml("x: 18446744073709551615").at("x").seed(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(yamlSentence("x: -1", [](const YamlNode& root) { root.at("x").seed(); }),
            "f.yaml:1: x: found -1, expected an integer from 0 to 18446744073709551615");
}

TEST(Yaml, TakesOnlyTrueAndFalseAsBoolean) {
  EXPECT_FALSE(parseYaml("x: false").at("x").boolean());
  for (const char* value : {"yes", "on", "True", "1"}) {
    EXPECT_THROW(parseYaml("x: " + std::string(value)).at("x").boolean(), ConfigError) << value;
  }
  EXPECT_EQ(yamlSentence("x: no", [](const YamlNode& root) { root.at("x").boolean(); }),
            "f.yaml:1: x: found 'no', expected true or false");
}

TEST(Yaml, NamesTheChoicesTheElementsAndTheKindExpected) {
  const auto oneOf = [](const YamlNode& root) { root.at("x").oneOf({"spherical", "revolute"}); };
  EXPECT_EQ(yamlSentence("x: ball", oneOf), "f.yaml:1: x: found 'ball', expected one of spherical, revolute");
  EXPECT_EQ(parseYaml("x: revolute").at("x").oneOf({"spherical", "revolute"}), "revolute");
  const auto vector = [](const YamlNode& root) { root.at("x").vector3(); };
  EXPECT_EQ(yamlSentence("x: [1, 2]", vector),
            "f.yaml:1: x: found a sequence of 2, expected a sequence of three numbers");
  EXPECT_EQ(yamlSentence("x: 1", vector), "f.yaml:1: x: found 1, expected a sequence of three numbers");
  EXPECT_EQ(yamlSentence("x: [1, 2,\n    z]", vector), "f.yaml:2: x[2]: found 'z', expected a finite number");
  EXPECT_EQ(yamlSentence("x: {}", [](const YamlNode& root) { root.at("x").items(); }),
            "f.yaml:1: x: found a map, expected a sequence");
  EXPECT_EQ(yamlSentence("x: {}", [](const YamlNode& root) { root.at("x").text(); }),
            "f.yaml:1: x: found a map, expected a text");
}

TEST(Yaml, NamesTheMissingKeyAndWhatStandsThere) {
  const auto read = [](const YamlNode& root) { root.at("bodies").items()[1].at("name"); };
  EXPECT_EQ(yamlSentence("bodies:\n  - {name: torso}\n  - {nmae: humerus, fixed: true}\n", read),
            "f.yaml:3: bodies[1]: found only nmae, fixed, expected the key 'name'");
  EXPECT_EQ(yamlSentence("bodies: [{}, {}]", read), "f.yaml:1: bodies[1]: found no keys, expected the key 'name'");
}

TEST(Yaml, AsksForAMapAtTheRoot) {
  const auto read = [](const YamlNode& root) { root.at("format"); };
  EXPECT_EQ(yamlSentence("", read), "f.yaml:1: found nothing, expected a map");
  EXPECT_EQ(yamlSentence("# only a comment\n", read), "f.yaml:1: found nothing, expected a map");
  EXPECT_EQ(yamlSentence("- 1\n", read), "f.yaml:1: found a sequence, expected a map");
  EXPECT_EQ(yamlSentence("just words\n", read), "f.yaml:1: found 'just words', expected a map");
  EXPECT_EQ(yamlSentence("", [](const YamlNode& root) { root.quantity("radius", "m"); }),
            "f.yaml:1: found nothing, expected a map");
}

TEST(Yaml, RefusesAKeyThatStandsTwice) {
  EXPECT_EQ(yamlSentence([] { parseYaml("a: 1\nb:\n  - {c: 1,\n     c: 2}\n"); }),
            "f.yaml:4: b[0].c: found the key twice, first on line 3, expected it once");
}

TEST(Yaml, RefusesWhatIsNoYaml) {
  EXPECT_EQ(yamlSentence([] { parseYaml("a: 1\nb: [1, 2\n"); }),
            "f.yaml:2: found no valid YAML: end of sequence flow not found");
  EXPECT_EQ(yamlSentence([] { parseYaml("a: \"open\nb: 1\n"); }),
            "f.yaml:2: found no valid YAML: illegal EOF in scalar");
  EXPECT_EQ(yamlSentence([] { parseYaml("a: 'open\n\n"); }), "f.yaml:1: found no valid YAML: illegal EOF in scalar");
  EXPECT_THROW(parseYaml("a: *nobody\n"), ConfigError);
  EXPECT_THROW(parseYaml(std::string(100000, '[')), ConfigError);
  EXPECT_EQ(yamlSentence([] { parseYaml("a: 1\n---\nb: 2\n"); }), "f.yaml:2: found a second document, expected one");
  EXPECT_EQ(yamlSentence([] { parseYaml("? [1, 2]\n: 3\n"); }), "f.yaml:1: found a sequence as a key, expected a name");
  EXPECT_EQ(yamlSentence([] { parseYaml("a: &loop\n  b: *loop\n"); }),
            "f.yaml:2: a.b: found an alias of a value that holds it, expected no such loop");
}

TEST(Yaml, NamesAFileThatCannotBeRead) {
  EXPECT_EQ(yamlSentence([] { YamlNode::load("no/such/file.yaml"); }),
            "no/such/file.yaml: cannot be read: No such file or directory");
}

TEST(YamlQuantity, ConvertsEverySpellingToTheAskedUnit) {
  EXPECT_EQ(parseYaml("radius_m: 0.006").quantity("radius", "m"), 0.006);
  EXPECT_DOUBLE_EQ(parseYaml("radius_mm: 6").quantity("radius", "m"), 0.006);
  EXPECT_DOUBLE_EQ(parseYaml("start_K: 293.15").quantity("start", "degC"), 20.0);
  EXPECT_TRUE(parseYaml("gravity_m_s2: [0, 0, -9.81]")
                  .vectorQuantity("gravity", "m_s2")
                  .isApprox(Eigen::Vector3d(0.0, 0.0, -9.81)));
  EXPECT_TRUE(
      parseYaml("point_cm: [1, 2, 3]").vectorQuantity("point", "m").isApprox(Eigen::Vector3d(0.01, 0.02, 0.03)));
  EXPECT_TRUE(parseYaml("radius_mm: 6").hasQuantity("radius", "m"));
  EXPECT_FALSE(parseYaml("radius_m_s: 6").hasQuantity("radius", "m"));
  EXPECT_EQ(parseYaml("a: 1").findQuantity("radius", "m"), std::nullopt);
  EXPECT_EQ(parseYaml("radius_m: 2").findQuantity("radius", "m"), 2.0);
}

TEST(YamlQuantity, ChecksTheRangeInTheAskedUnit) {
  const Range range{0.0, 0.1, true, "a number > 0 and <= 0.1"};
  const auto read = [&](const YamlNode& root) { root.quantity("radius", "m", range); };
  EXPECT_EQ(parseYaml("radius_mm: 6").quantity("radius", "m", range), 0.006);
  EXPECT_EQ(yamlSentence("a: 1\nradius_mm: 600", read),
            "f.yaml:2: radius_mm: found 600 (0.6 m), expected a number > 0 and <= 0.1");
  EXPECT_EQ(yamlSentence("radius_m: -1", read), "f.yaml:1: radius_m: found -1, expected a number > 0 and <= 0.1");
  EXPECT_EQ(yamlSentence("radius_mm: thin", read),
            "f.yaml:1: radius_mm: found 'thin', expected a number > 0 and <= 0.1");
}

TEST(YamlQuantity, NamesTheUnitThatDoesNotFit) {
  const auto read = [](const YamlNode& root) { root.at("part").quantity("radius", "m"); };
  EXPECT_EQ(yamlSentence("part:\n  name: bone\n  radius_furlong: 1\n", read),
            "f.yaml:3: part.radius_furlong: unit 'furlong' does not exist, expected one of m, mm, cm");
  EXPECT_EQ(yamlSentence("part: {radius_kg: 1}", read),
            "f.yaml:1: part.radius_kg: unit 'kg' is of another kind, expected one of m, mm, cm");
  EXPECT_EQ(yamlSentence("part: {radius: 1}", read),
            "f.yaml:1: part.radius: unit is missing, expected one of m, mm, cm");
  EXPECT_EQ(yamlSentence("part: {name: bone}", read),
            "f.yaml:1: part: found only name, expected one of the keys radius_m, radius_mm, radius_cm");
}

TEST(YamlQuantity, RefusesAQuantityInTwoUnits) {
  EXPECT_EQ(yamlSentence("radius_m: 0.006\nradius_mm: 6", [](const YamlNode& root) { root.quantity("radius", "m"); }),
            "f.yaml:2: radius_mm: found 'radius_m' beside it, expected only one of them");
}

TEST(YamlExpectAllRead, SuggestsTheNearestKeyOrListsTheKnownOnes) {
  const auto read = [](const YamlNode& root) {
    const YamlNode muscle = root.at("muscles").items()[0];
    muscle.at("name");
    muscle.find("path");
    muscle.find("path");  // listed once
    muscle.findQuantity("spindle_radius", "m");
    muscle.expectAllRead();
  };
  const std::string muscle = "muscles:\n  - name: biceps\n    ";
  EXPECT_EQ(yamlSentence(muscle + "spindle_raduis_mm: 6\n", read),
            "f.yaml:3: muscles[0].spindle_raduis_mm: found an unknown key, expected 'spindle_radius_mm'");
  EXPECT_EQ(yamlSentence(muscle + "spindle_radius_furlong: 6\n", read),
            "f.yaml:3: muscles[0].spindle_radius_furlong: unit 'furlong' does not exist, expected one of m, mm, cm");
  EXPECT_EQ(yamlSentence(muscle + "colour: red\n", read),
            "f.yaml:3: muscles[0].colour: found an unknown key, expected one of name, path, spindle_radius_m");
  // A key that is there already is no suggestion for another.
  EXPECT_EQ(yamlSentence(muscle + "names: x\n", read),
            "f.yaml:3: muscles[0].names: found an unknown key, expected one of name, path, spindle_radius_m");
  EXPECT_EQ(yamlSentence(muscle + "spindle_radius_cm: 6\n", read), "no error");
}

TEST(YamlExpectAllRead, FindsKeysInMapsNobodyLookedInto) {
  const auto read = [](const YamlNode& root) {
    root.at("a");
    root.expectAllRead();
  };
  EXPECT_EQ(yamlSentence("a: [1, {b: 2}]\n", read), "f.yaml:1: a[1].b: found an unknown key, expected none here");
  EXPECT_EQ(yamlSentence("a: [1, {}]\n", read), "no error");
}

TEST(YamlAliases, ShareTheirAnchorsValueAndItsReading) {
  const YamlNode root = parseYaml("cord: &cord {stiffness_N_m: 900}\nmuscles:\n  - {cord: *cord}\n  - {cord: *cord}\n");
  const std::vector<YamlNode> muscles = root.at("muscles").items();
  EXPECT_EQ(muscles[0].at("cord").quantity("stiffness", "N_m"), 900.0);
  EXPECT_EQ(muscles[1].at("cord").path(), "muscles[1].cord");
  root.at("cord");
  root.expectAllRead();
}

TEST(YamlAliases, ThatMultiplyAreWalkedOnce) {
  std::string text = "a0: &a0 [1, 2]\n";
  for (int i = 1; i < 40; ++i) {
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [*a" + std::to_string(i - 1) + ", *a" +
            std::to_string(i - 1) + "]\n";
  }
  const YamlNode root = parseYaml(text);
  for (const std::string& key : root.keys()) root.at(key);
  root.expectAllRead();
}

TEST(YamlLimits, RefuseWhatIsTooDeepOrTooLarge) {
  for (const std::string& opening : {std::string(100'000, '['), std::string(100'000, '{'), [] {
                                       std::string block;
                                       for (int i = 0; i < 2'000; ++i) block += std::string(i, ' ') + "a:\n";
                                       return block;
                                     }()}) {
    EXPECT_NE(yamlSentence([&] { parseYaml("a: " + opening); }), "no error");
  }
  const std::string deep = std::string(64, '[') + std::string(64, ']');
  EXPECT_EQ(yamlSentence([&] { parseYaml(deep); }), "no error");
  EXPECT_EQ(yamlSentence([&] { parseYaml("[" + deep + "]"); }),
            "f.yaml:1: found values nested more than 64 deep, expected less");
  EXPECT_EQ(yamlSentence([&] { parseYaml("a: " + std::string(17 << 20, 'x')); }),
            "f.yaml: found 17 MiB, expected at most 16");
}

TEST(YamlLimits, ManyKeysTakeLinearTime) {
  std::string text;
  for (int i = 0; i < 50'000; ++i) text += "key" + std::to_string(i) + ": 1\n";
  EXPECT_EQ(parseYaml(text).keys().size(), 50'000u);
}

TEST(YamlLimits, RefuseAbsurdQuantities) {
  EXPECT_EQ(yamlSentence("mass_g: 1e20", [](const YamlNode& root) { root.quantity("mass", "kg"); }),
            "f.yaml:1: mass_g: found 1e+17 kg, expected a size of at most 1e+06");
  EXPECT_EQ(yamlSentence("at_m: [0, -1e9, 0]", [](const YamlNode& root) { root.vectorQuantity("at", "m"); }),
            "f.yaml:1: at_m: found 1e+09 m, expected at most 100000");
  EXPECT_EQ(yamlSentence("n: 1e20", [](const YamlNode& root) { root.at("n").number(); }), "no error");
}

TEST(YamlLimits, ALongValueIsAbridged) {
  const std::string sentence =
      yamlSentence("a: " + std::string(1 << 20, 'x'), [](const YamlNode& root) { root.at("a").number(); });
  EXPECT_LT(sentence.size(), 200u);
}

}  // namespace
}  // namespace simgap
