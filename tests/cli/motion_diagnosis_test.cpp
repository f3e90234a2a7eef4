// `diagnose --motions` from end to end, and what it refuses.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "support/motions.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;

class MotionDiagnosisTest : public CliTest {
 protected:
  MotionDiagnosisTest() {
    reality::MotionRigOptions options;
    options.duration = 3.0;
    options.capture_delay = 0.05;
    put("forearm.yaml", reality::toYaml(movingForearm().arm));
    put("forearm_config.yaml", forearmConfig());
    putMotions(folder_, "motions.yaml", 0, 4, options);
    putMotions(folder_, "unseen.yaml", 4, 3, options);
    putMotions(folder_, "further.yaml", 7, 3, options);
  }
  Arguments diagnosis(const std::string& directory, const Arguments& more = {}) const {
    Arguments all{"diagnose",    "forearm.yaml", "--motions",           "motions.yaml", "--validation-motions",
                  "unseen.yaml", "--config",     "forearm_config.yaml", "-q",           "-o",
                  directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(MotionDiagnosisTest, WritesAModelThatPlaysAndThreadsDoNotChangeABit) {
  const Arguments effects{"--effects", "joint-clock-offset,payload,command-latency"};
  succeed(diagnosis("out", effects));
  const Json result = Json::parse(text("out/result.json"));
  EXPECT_EQ(result.at("format"), "simgap/diagnose/1");
  EXPECT_EQ(result.at("motions").size(), 7u);
  for (const char* file : {"model.yaml", "baseline.yaml", "hypotheses.csv", "evidence.csv", "residuals.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(path(std::string("out/") + file))) << file;
  }
  EXPECT_THAT(text("out/report.html"), HasSubstr("What each motion says"));
  EXPECT_THAT(text("out/report.html"), HasSubstr("The movement"));
  const CsvTable shown = CsvTable::parse(text("out/arm_bodies.csv"), "arm_bodies.csv");
  EXPECT_THAT(shown.text("state"), testing::AllOf(testing::Contains("measured"), testing::Contains("without causes")));
  if (result.at("causes").empty()) {
    EXPECT_EQ(text("out/model.yaml"), text("out/baseline.yaml"));
  }
  succeed({"validate", "out/model.yaml", "--motions", "unseen.yaml", "-q", "-o", "played"});
  succeed(diagnosis("again", {effects[0], effects[1], "--threads", "1"}));
  EXPECT_EQ(text("again/model.yaml"), text("out/model.yaml"));
}

TEST_F(MotionDiagnosisTest, ItsModelsAreAskedAboutAChangeAndWhatToRecordNext) {
  succeed(diagnosis("out", {"--effects", "joint-clock-offset,payload,command-latency"}));
  put("off.yaml", "format: simgap/change/1\nname: clock mended\nchanges: [{kind: undo, cause: joint-clock-offset}]\n");
  put("hung.yaml",
      "format: simgap/change/1\nchanges: [{kind: mass, body: link1, at_m: [0, 0, -0.1], mass_kg: 0.2, mass_sd_kg: "
      "0.01}]\n");
  const Json found = Json::parse(text("out/result.json"));
  ASSERT_EQ(found.at("causes").at(0).at("effect"), "joint-clock-offset");
  succeed({"intervene", "out", "--change", "hung.yaml", "--change", "off.yaml", "-q", "-o", "foreseen"});
  EXPECT_EQ(Json::parse(text("foreseen/result.json")).at("best"), "clock mended");
  succeed({"intervene", "out", "--motions", "further.yaml", "-q", "-o", "again"});
  EXPECT_EQ(Json::parse(text("again/result.json")).at("verdict"), "confirmed");
  EXPECT_THAT(text("again/report.html"), HasSubstr("RMS error [sd of the noise]"));
  succeed({"intervene", "out", "--change", "off.yaml", "--motions", "further.yaml", "-q", "-o", "not_made"});
  EXPECT_NE(Json::parse(text("not_made/result.json")).at("verdict"), "confirmed");
  succeed({"design", "--separate", "out", "--speeds", "0.5,1", "-q", "-o", "next"});
  succeed({"simulate", "forearm.yaml", "--commands", "next/next_1.csv", "-q", "-o", "played"});
  succeed({"design", "--separate", "out", "--speeds", "0.5,1", "--threads", "1", "-q", "-o", "next_again"});
  EXPECT_EQ(text("next_again/result.json"), text("next/result.json"));
  succeed({"design", "--separate", "out", "--speeds", "0.5,1", "--max-duration-s", "4", "-q", "-o", "brief"});
  const Json brief = Json::parse(text("brief/result.json"));  // they lasted 3 s
  for (const Json& one : brief.at("protocols")) EXPECT_EQ(one.at("beyond").is_null(), one.at("speed") == 1.0) << one;
  const ProcessResult weak = simgap({"design", "--separate", "out", "--max-tension-N", "0.01", "-o", "weak"});
  EXPECT_EQ(weak.exit_code, 2);
  EXPECT_THAT(weak.err, HasSubstr("is beyond the limits"));

  expectRefused({"intervene", "out", "--motions", "unseen.yaml", "-o", "no"}, 3,
                "found what the diagnosis in out has seen");
  expectRefused({"intervene", "out", "-o", "no"}, 2, "found neither --change nor --motions");
  expectRefused({"intervene", "out", "--poses", "p.csv", "-o", "no"}, 2,
                "with a diagnosis of motions, expected --motions");
  expectRefused({"intervene", "out", "--change", "off.yaml", "hung.yaml", "--motions", "further.yaml", "-o", "no"}, 2,
                "found 2 files of --change with --motions");
  put("none.yaml", "format: simgap/change/1\nchanges: [{kind: undo, cause: supply-sag}]\n");
  expectRefused({"intervene", "out", "--change", "none.yaml", "--motions", "further.yaml", "-o", "no"}, 2,
                "which no model of the diagnosis holds");
  put("out/candidates/covariance_01.csv", "z0,z1\n1,0\n0,1\n");
  expectRefused({"intervene", "out", "--change", "off.yaml", "-o", "no"}, 2, "found a covariance of 2 parameters");
}

TEST_F(MotionDiagnosisTest, WhatItCannotTakeIsSaid) {
  const auto with = [&](const std::string& from, const std::string& to, const Arguments& more = {}) {
    Arguments all = diagnosis("no", more);
    *std::ranges::find(all, from) = to;
    return all;
  };
  expectRefused(with("motions.yaml", "none.yaml"), 2, "none.yaml");
  expectRefused(with("unseen.yaml", "motions.yaml"), 2, "found the motions of --motions, expected others");
  expectRefused(diagnosis("no", {"--effects", "payloads"}), 2, "--effects: found 'payloads', expected some of");
  expectRefused(diagnosis("no", {"--self-test", "2"}), 2, "found --self-test with --motions");
  expectRefused(diagnosis("no", {"--holdout", "0.3"}), 2, "--holdout: found '0.3'");
  expectRefused(diagnosis("no", {"--poses", "p.csv"}), 2, "found none or several of --log, --poses and --motions");
  put("degrees.yaml", replaced(text("motions.yaml"), "motions_m0_muscles.csv", "short.csv"));
  put("short.csv", "time_s,setpoint_muscle1_rad\n0,1\n1,2\n");
  expectRefused(with("motions.yaml", "degrees.yaml"), 3, "short.csv:1: muscle muscle2: found no command");
}

}  // namespace
}  // namespace simgap::test
