#include "simgap/core/units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace simgap {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

double convert(double value, std::string_view suffix, std::string_view target) {
  const auto conversion = unitConversion(suffix, target);
  EXPECT_TRUE(conversion) << suffix << " -> " << target;
  return conversion ? (*conversion)(value) : std::numeric_limits<double>::quiet_NaN();
}

TEST(Units, ConvertToSi) {
  EXPECT_DOUBLE_EQ(convert(180.0, "deg", "rad"), 3.14159265358979323846);
  EXPECT_DOUBLE_EQ(convert(60.0, "rpm", "rad_s"), 2.0 * 3.14159265358979323846);
  EXPECT_DOUBLE_EQ(convert(90.0, "deg_s", "rad_s"), 3.14159265358979323846 / 2.0);
  EXPECT_DOUBLE_EQ(convert(250.0, "mA", "A"), 0.25);
  EXPECT_DOUBLE_EQ(convert(30.0, "mNm", "Nm"), 0.03);
  EXPECT_DOUBLE_EQ(convert(6.0, "mm", "m"), 0.006);
  EXPECT_DOUBLE_EQ(convert(6.0, "cm", "m"), 0.06);
  EXPECT_DOUBLE_EQ(convert(6.0, "mm_s", "m_s"), 0.006);
  EXPECT_DOUBLE_EQ(convert(20.0, "ms", "s"), 0.02);
  EXPECT_DOUBLE_EQ(convert(3.0, "bar", "Pa"), 3e5);
  EXPECT_DOUBLE_EQ(convert(3.0, "kPa", "Pa"), 3e3);
  EXPECT_DOUBLE_EQ(convert(0.3, "MPa", "Pa"), 3e5);
  EXPECT_DOUBLE_EQ(convert(900.0, "g", "kg"), 0.9);
  EXPECT_DOUBLE_EQ(convert(0.9, "N_mm", "N_m"), 900.0);
  EXPECT_DOUBLE_EQ(convert(1.2, "g_cm3", "kg_m3"), 1200.0);
  EXPECT_DOUBLE_EQ(convert(0.3, "mH", "H"), 3e-4);
  EXPECT_DOUBLE_EQ(convert(20.0, "kHz", "Hz"), 2e4);
}

TEST(Units, ConvertTemperatureWithItsOffsetBothWays) {
  EXPECT_NEAR(convert(300.0, "K", "degC"), 26.85, 1e-12);
  EXPECT_DOUBLE_EQ(convert(26.85, "degC", "K"), 300.0);
  EXPECT_DOUBLE_EQ(convert(26.85, "C", "K"), 300.0);
  EXPECT_EQ(convert(26.85, "C", "degC"), 26.85);
}

TEST(Units, ConvertBetweenUnitsNeitherOfWhichIsSi) {
  EXPECT_DOUBLE_EQ(convert(25.0, "mm", "cm"), 2.5);
  EXPECT_DOUBLE_EQ(convert(1.0, "rpm", "deg_s"), 6.0);
}

TEST(Units, OfOneKindConvertThereAndBack) {
  for (const char* home : {"rad", "rad_s", "A", "Nm", "m", "m_s", "s", "Pa", "degC", "kg", "N_m", "kg_m3", "H", "Hz"}) {
    for (const std::string& unit : unitsLike(home)) {
      EXPECT_NEAR(convert(convert(12.5, unit, home), home, unit), 12.5, 1e-12) << unit;
    }
  }
}

TEST(Units, OfTheSameSpellingLeaveAValueUntouched) {
  const auto conversion = unitConversion("deg", "deg");
  ASSERT_TRUE(conversion);
  EXPECT_EQ(conversion->factor, 1.0);
  EXPECT_EQ(conversion->offset, 0.0);
}

TEST(Units, OfDifferentKindsDoNotConvert) {
  EXPECT_FALSE(unitConversion("Nm", "N_m"));  // a torque is no stiffness
  EXPECT_FALSE(unitConversion("rad", "rad_s"));
  EXPECT_FALSE(unitConversion("Ns_m", "Nms"));
  EXPECT_FALSE(unitConversion("furlong", "m"));
  EXPECT_FALSE(unitConversion("m", "furlong"));
  EXPECT_FALSE(unitConversion("", ""));
}

TEST(Units, AreKnownByTheirExactSpelling) {
  EXPECT_TRUE(isUnit("kg_m2"));
  EXPECT_FALSE(isUnit("NM"));
  EXPECT_FALSE(isUnit("_m"));
  EXPECT_FALSE(isUnit(""));
}

TEST(Units, OfOneKindAreListedInTheOrderOfTheTable) {
  EXPECT_THAT(unitsLike("m"), ElementsAre("m", "mm", "cm"));
  EXPECT_THAT(unitsLike("deg"), ElementsAre("rad", "deg"));
  EXPECT_THAT(unitsLike("Nms"), ElementsAre("Nms", "Nms_rad"));
  EXPECT_THAT(unitsLike("Vs"), ElementsAre("Vs", "V_s_rad", "Vs_rad"));
  EXPECT_THAT(unitsLike("furlong"), IsEmpty());
}

TEST(SplitUnit, TakesTheLongestUnit) {
  const auto expectSplit = [](std::string_view name, std::string_view stem, std::string_view unit) {
    const UnitName split = splitUnit(name);
    EXPECT_EQ(split.stem, stem) << name;
    EXPECT_EQ(split.unit, unit) << name;
  };
  expectSplit("shaft_biceps_deg", "shaft_biceps", "deg");
  expectSplit("velocity_rad_s", "velocity", "rad_s");
  expectSplit("gravity_m_s2", "gravity", "m_s2");
  expectSplit("stiffness_N_m", "stiffness", "N_m");
  expectSplit("constant_V_s_rad", "constant", "V_s_rad");
  expectSplit("shoulder_qw", "shoulder_qw", "");
  expectSplit("pose", "pose", "");
  expectSplit("s", "s", "");
  expectSplit("_s", "_s", "");
  expectSplit("", "", "");
}

TEST(MatchQuantity, FindsEverySpellingOfAQuantity) {
  const std::vector<std::string> names = {"elbow_rad_s", "elbow_deg", "elbow", "elbow_rad"};
  const auto matches = matchQuantity(names, "elbow", "rad");
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].index, 1u);
  EXPECT_EQ(matches[0].unit, "deg");
  EXPECT_EQ(matches[1].index, 3u);
  ASSERT_EQ(matchQuantity(names, "elbow", "").size(), 1u);
  EXPECT_EQ(matchQuantity(names, "elbow", "")[0].index, 2u);
}

TEST(FindUnitMistake, SaysWhatIsWrongWithTheUnit) {
  const auto sentence = [](const std::string& name) {
    const auto mistake = findUnitMistake({&name, 1}, "radius", "m");
    return mistake ? mistake->sentence : "";
  };
  EXPECT_EQ(sentence("radius_furlong"), "unit 'furlong' does not exist, expected one of m, mm, cm");
  EXPECT_EQ(sentence("radius_m_s"), "unit 'm_s' is of another kind, expected one of m, mm, cm");
  EXPECT_EQ(sentence("radius"), "unit is missing, expected one of m, mm, cm");
  EXPECT_EQ(sentence("radius_of_spindle_m"), "");  // another quantity
  EXPECT_EQ(sentence("radiuses_m"), "");
}

TEST(NearestName, CorrectsASlipButDoesNotGuess) {
  const std::vector<std::string> names = {"radius_m", "name", "mass_kg"};
  EXPECT_EQ(nearestName("raduis_m", names), "radius_m");
  EXPECT_EQ(nearestName("nmae", names), "name");
  EXPECT_EQ(nearestName("colour", names), "");
  EXPECT_EQ(nearestName("radius_m", {}), "");
}

TEST(ParseNumber, TakesPlainDecimalAndScientificNotationOnly) {
  EXPECT_EQ(parseNumber("1e3"), 1000.0);
  EXPECT_EQ(parseNumber("+5"), 5.0);
  EXPECT_EQ(parseNumber("-0.25E-1"), -0.025);
  EXPECT_EQ(parseNumber(".5"), 0.5);
  EXPECT_EQ(parseNumber("010"), 10.0);
  for (const char* text : {"",   "+",  "-",   "+-5", "++5",  "0x10", "1_000", "1,5",  "1:30",  " 5",
                           "5 ", "1e", "abc", "nan", ".nan", "inf",  "-inf",  ".inf", "1e999", "5m"}) {
    EXPECT_FALSE(parseNumber(text)) << "'" << text << "'";
  }
}

}  // namespace
}  // namespace simgap
