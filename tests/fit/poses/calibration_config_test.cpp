#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/fit/poses/calibration.h"
#include "support/files.h"

namespace simgap {
namespace {

using test::replaced;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kConfig = R"(format: simgap/calibration/1
parameters:
  - {pattern: "muscles.*.attachments", step: 2.0e-3, prior_sd: 7.0e-3}
  - {pattern: "muscles.*.spindle_radius_m", step: 5.0e-5, lower: 5.0e-3, upper: 1.0e-2, prior_sd_percent: 5}
strategy:
  mu: 2
  lambda: 8
  generations: 30
  tau: 0.3
  tau_prime: 0.1
  target_fitness: 1.0e-3
  seed: 18446744073709551615
protocol:
  step_ms: 1
  acquisition_s: 2
  settle_s: 3
  steady_s: 0.4
  max_shaft_error_deg: 7
  max_velocity_deg_s: 1
  early_acquisition: false
evaluator: bullet
optimizer: es
capture_sd_deg: 0.2
)";

CalibrationConfig readConfig(const std::string& text) {
  return CalibrationConfig::read(YamlNode::parse(text, "c.yaml"));
}
std::string errorWith(std::string_view from, std::string_view to) {
  return test::errorOf([&] { readConfig(replaced(kConfig, from, to)); });
}

TEST(CalibrationConfig, ReadsWhatStandsInIt) {
  const CalibrationConfig config = readConfig(kConfig);
  ASSERT_EQ(config.parameters.size(), 2u);
  EXPECT_EQ(config.parameters[0].pattern, "muscles.*.attachments");
  EXPECT_EQ(config.parameters[0].prior_sd, 7e-3);
  EXPECT_FALSE(config.parameters[0].lower);
  EXPECT_EQ(config.parameters[1].upper, 1e-2);
  EXPECT_EQ(config.strategy.mu, 2);
  EXPECT_EQ(config.strategy.tau, 0.3);
  EXPECT_EQ(config.strategy.seed, 18446744073709551615u);
  EXPECT_EQ(config.protocol.arm.step, 1e-3);
  EXPECT_NEAR(config.protocol.max_shaft_error, 7 * kDegree, 1e-16);
  EXPECT_NEAR(config.protocol.max_velocity, kDegree, 1e-16);
  EXPECT_FALSE(config.protocol.early_acquisition);
  EXPECT_NEAR(config.noise.capture_sd, 0.2 * kDegree, 1e-16);
}

TEST(CalibrationConfig, IsTheSameAfterAFile) {
  for (const std::string& text :
       {kConfig, replaced(kConfig, "optimizer: es", "objective: paper"),
        replaced(kConfig, "optimizer: es", "only_poses: 'r*'"),
        test::readText(test::sourceFile("configs/calibrate_arm.yaml")),
        replaced(kConfig, "\"muscles.*.attachments\"", R"('muscles."\odd: #name".attachments')"),
        std::string("format: simgap/calibration/1\nparameters: [{pattern: gravity_m_s2, step: 1}]\n")}) {
    const std::string written = readConfig(text).toYaml();
    SCOPED_TRACE(written);
    EXPECT_EQ(readConfig(written).toYaml(), written);
    const CalibrationConfig a = readConfig(text), b = readConfig(written);
    ASSERT_EQ(a.parameters.size(), b.parameters.size());
    for (std::size_t i = 0; i < a.parameters.size(); ++i) {
      EXPECT_EQ(a.parameters[i].pattern, b.parameters[i].pattern);
      EXPECT_EQ(a.parameters[i].step, b.parameters[i].step);
      EXPECT_EQ(a.parameters[i].lower, b.parameters[i].lower);
      EXPECT_EQ(a.parameters[i].upper, b.parameters[i].upper);
      EXPECT_EQ(a.parameters[i].prior_sd, b.parameters[i].prior_sd);
      EXPECT_EQ(a.parameters[i].prior_sd_percent, b.parameters[i].prior_sd_percent);
    }
    EXPECT_EQ(a.optimizer, b.optimizer);
    EXPECT_EQ(a.objective, b.objective);
    EXPECT_EQ(a.strategy.seed, b.strategy.seed);
    EXPECT_EQ(a.strategy.tau, b.strategy.tau);
    EXPECT_EQ(a.strategy.tau_prime, b.strategy.tau_prime);
    EXPECT_EQ(a.strategy.target_fitness, b.strategy.target_fitness);
    EXPECT_EQ(a.protocol.max_shaft_error, b.protocol.max_shaft_error);
    EXPECT_EQ(a.protocol.max_velocity, b.protocol.max_velocity);
    EXPECT_EQ(a.protocol.arm.step, b.protocol.arm.step);
    EXPECT_EQ(a.noise.capture_sd, b.noise.capture_sd);
  }
}

TEST(CalibrationConfig, NamesFileLineAndPathOfWhatIsWrong) {
  EXPECT_THAT(errorWith("calibration/1", "arm/1"), StartsWith("2: c.yaml:1: format: found 'simgap/arm/1'"));
  EXPECT_THAT(errorWith("mu: 2", "mu: 0"), StartsWith("2: c.yaml:6: strategy.mu: found 0"));
  EXPECT_THAT(errorWith("mu: 2", "mu: 2.5"), StartsWith("2: c.yaml:6: strategy.mu: found 2.5"));
  EXPECT_THAT(errorWith("mu: 2", "nu: 2"), StartsWith("2: c.yaml:6: strategy.nu: found an unknown key"));
  EXPECT_THAT(errorWith("seed: 1844", "seed: -1844"), StartsWith("2: c.yaml:12: strategy.seed: "));
  EXPECT_THAT(errorWith("tau: 0.3", "tau: -1"), StartsWith("2: c.yaml:9: strategy.tau: found -1"));
  EXPECT_THAT(errorWith("1.0e-3\n", ".nan\n"), StartsWith("2: c.yaml:11: strategy.target_fitness: "));
  EXPECT_THAT(errorWith("step_ms: 1", "step_ms: 0"), StartsWith("2: c.yaml:14: protocol.step_ms: found 0"));
  EXPECT_THAT(errorWith("step_ms", "step_deg"), StartsWith("2: c.yaml:14: protocol.step_deg: "));
  EXPECT_THAT(errorWith("early_acquisition: false", "early_acquisition: 0"),
              StartsWith("2: c.yaml:20: protocol.early_acquisition: found 0"));
  EXPECT_THAT(errorWith("bullet", "mujoco"), StartsWith("2: c.yaml:21: evaluator: found 'mujoco'"));
  EXPECT_THAT(errorWith("optimizer: es", "optimizer: cma"), StartsWith("2: c.yaml:22: optimizer: found 'cma'"));
  EXPECT_THAT(errorWith("optimizer: es", "objective: half"), StartsWith("2: c.yaml:22: objective: found 'half'"));
  EXPECT_THAT(errorWith("capture_sd_deg: 0.2", "capture_sd_deg: 0"), StartsWith("2: c.yaml:23: capture_sd_deg: "));
  EXPECT_THAT(errorWith("lower: 5.0e-3", "lower: 5"), StartsWith("2: c.yaml:4: parameters[1]: lower 5 is above upper"));
}

TEST(CalibrationConfig, NamesTheBlockOfNumbersThatDoNotFitTogether) {
  EXPECT_THAT(errorWith("lambda: 8", "lambda: 1"), StartsWith("2: c.yaml:6: strategy: "));
  EXPECT_THAT(errorWith("generations: 30", "generations: 0"), StartsWith("2: c.yaml:"));
  EXPECT_THAT(errorWith("steady_s: 0.4", "steady_s: 4"), StartsWith("2: c.yaml:14: protocol: "));
  EXPECT_THAT(errorWith("steady_s: 0.4", "steady_s: 4"), HasSubstr("steady_s 4 is longer than settle_s 3"));
}

}  // namespace
}  // namespace simgap
