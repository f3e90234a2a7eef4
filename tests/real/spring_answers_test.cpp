// The series spring of sea_rmd_x8_spring (number 5, output locked): six ramps of growing amplitude, force against one
// deflection. Its stiffness falls from 2531 N m/rad in the smallest ramp to 1529 in the largest, and every ramp is a
// loop.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "real/real_logs.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"
#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

class RealSprings : public testing::Test {
 protected:
  RealSprings() {
    if (!realFolder()) return;
    CsvWriter pooled({"session", "time_s", "torque_Nm", "deflection_rad"});
    for (int ramp = 1; ramp <= 6; ++ramp) {
      const CsvTable table = ramps(ramp);
      const auto time = table.quantity("time", "s"), torque = table.quantity("measured_torque", "Nm");
      const auto deflection = table.quantity("spring_deflection", "rad");
      for (std::size_t i = 0; i < time.size(); ++i) {
        pooled.add(static_cast<double>(ramp)).add(time[i]).add(torque[i]).add(deflection[i]).endRow();
      }
    }
    folder_.put("ramps.csv", pooled.text());
  }
  static CsvTable ramps(int ramp) {
    return CsvTable::load(*realFolder() / fmt::format("sea_rmd_x8_spring/spring5_ramp{}.csv.gz", ramp));
  }
  Json run(std::vector<std::string> words) const {
    words.insert(words.begin(), SIMGAP_BINARY);
    words.insert(words.end(), {"-q", "--force", "-o", "d"});
    const ProcessResult result = runProcess(words, folder_.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(readText(folder_.path() / "d/result.json"));
  }
  static double valueIn(const Json& parameters, const std::string& name) {
    for (const Json& p : parameters) {
      if (p.at("name") == name) return p.at("value");
    }
    return std::nan("");
  }
  /// Stiffness of a straight line through one ramp alone.
  double stiffnessOf(int ramp) const {
    folder_.put("one.csv.gz", readText(*realFolder() / fmt::format("sea_rmd_x8_spring/spring5_ramp{}.csv.gz", ramp)));
    return valueIn(run({"fit-spring", "one.csv.gz", "--map", "torque_Nm=measured_torque_Nm", "--map",
                        "deflection_rad=spring_deflection_rad"})
                       .at("parameters"),
                   "stiffness");
  }
  TemporaryFolder folder_;
};

TEST_F(RealSprings, TheSeriesSpringSoftensWithHysteresis) {
  if (!realFolder()) GTEST_SKIP() << "no measured logs: set SIMGAP_REAL_DATA to their folder";
  const Json result = run({"diagnose", "spring", "--log", "ramps.csv"});
  ASSERT_FALSE(result.at("causes").empty()) << result.at("sentence");
  const Json cause = result.at("causes")[0];
  ASSERT_EQ(cause.at("effect"), "spring-hysteresis") << result.at("sentence");
  EXPECT_GT(cause.at("gain_ci95")[0].get<double>(), 0.0);
  EXPECT_GT(result.at("explained_percent").get<double>(), 60.0);
  // What the bristles add to the stiffness until they slip is what the spring loses with amplitude.
  const double lost = valueIn(cause.at("parameters"), "friction") / valueIn(cause.at("parameters"), "slip");
  const YamlNode model = YamlNode::load(folder_.path() / "d/model.yaml");
  const double left = model.at("parameters").at("stiffness").at("value").number();
  EXPECT_NEAR(left + lost, stiffnessOf(1), 0.1 * stiffnessOf(1));
  EXPECT_LT(left, stiffnessOf(6));
}

// Without friction the bend leaves more than twice the error: the loops.
TEST_F(RealSprings, SofteningAloneLeavesTheLoops) {
  if (!realFolder()) GTEST_SKIP() << "no measured logs: set SIMGAP_REAL_DATA to their folder";
  const auto leftBy = [&](const char* effects) {
    const Json result = run({"diagnose", "spring", "--log", "ramps.csv", "--effects", effects});
    double gain = 0.0;
    for (const Json& c : result.at("candidates")) {
      if (c.at("effect") == "spring-softening") gain = c.at("gain_heldout_percent");
    }
    for (const Json& c : result.at("causes")) gain = c.at("gain_heldout_percent");
    return 100.0 - gain;
  };
  const double bend = leftBy("spring-softening"), friction = leftBy("spring-hysteresis");
  EXPECT_LT(bend, 90.0);  // it explains something
  EXPECT_GT(bend, 2.0 * friction);
}

}  // namespace
}  // namespace simgap::test
