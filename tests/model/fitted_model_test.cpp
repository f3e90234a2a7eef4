#include "simgap/model/actuator/fitted_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

std::string sentenceOf(const std::string& value, const std::string& covariance) {
  const std::string text = "format: simgap/friction/1\nparameters:\n  a: {value: " + value +
                           ", unit: Nm}\n  b: {value: 1, unit: Nm, fixed: true}\ncovariance: " + covariance + "\n";
  return errorOf([&] { readFittedModel(YamlNode::parse(text, "m.yaml")); });
}

TEST(FittedModelFile, RefusesWhatNoFitCanHaveFound) {
  EXPECT_EQ(sentenceOf("0.5", "[[4, 0], [0, 0]]"), "no error");
  EXPECT_EQ(sentenceOf("0.5", "[[4, -2], [-2, 1]]"), "no error") << "a correlation of -1";
  EXPECT_THAT(sentenceOf("0.5", "[[-2e9, 0], [0, 0]]"), HasSubstr("found the variance -2e+09, expected none below 0"));
  EXPECT_THAT(sentenceOf("0.5", "[[4, 2.1], [2.1, 1]]"), HasSubstr("found 2.1 in row 1, column 2"));
  EXPECT_THAT(sentenceOf("1e20", "[[4, 0], [0, 0]]"),
              HasSubstr("parameters.a.value: found 1e20, expected a number of"));
}

}  // namespace
}  // namespace simgap::test
