// intervene and design --separate as a user runs them on what diagnose --log has left. The bench is another program's.
#include <gmock/gmock.h>

#include "cli/cli_fixture.h"
#include "reality/drive_draws.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class InterveneLog : public CliTest {
 protected:
  InterveneLog() {
    put("log.csv", logOf(11, 0.5));
    put("off.yaml", "format: simgap/change/1\nchanges: [{kind: undo, cause: current-bias}]\n");
    put("load.yaml", "format: simgap/change/1\nname: twice the load\nchanges: [{kind: load, factor: 2}]\n");
    succeed({"diagnose", "classic", "--log", "log.csv", "--effects", "current-bias,direction-asymmetry,torque-bias",
             "-q", "-o", "d"});
  }

  static std::string logOf(std::uint64_t seed, double bias) {
    reality::DriveRig rig = reality::drawRig(3);
    rig.rows = 6000;
    rig.seed = seed;
    reality::DriveSecret secret;
    secret.current_bias = bias;
    return reality::recordDrive(rig, secret).csv();
  }
  Json resultOf(const std::string& run) const { return Json::parse(text(run + "/result.json")); }
};

TEST_F(InterveneLog, ForeseesJudgesAndChoosesTheNextLog) {
  EXPECT_THAT(text("d/candidates/candidates.yaml"), HasSubstr("format: simgap/log-candidates/1"));
  succeed({"intervene", "d", "--change", "off.yaml", "--change", "load.yaml", "-q", "-o", "foreseen"});
  const Json foreseen = resultOf("foreseen");
  EXPECT_EQ(foreseen.at("verdict"), "foreseen");
  EXPECT_EQ(foreseen.at("unit"), "A");
  EXPECT_EQ(foreseen.at("changes").at(1).at("name"), "twice the load");
  EXPECT_THAT(text("foreseen/report.html"), HasSubstr("Predicted after the change"));

  put("after.csv", logOf(12, 0.0));
  succeed({"intervene", "d", "--change", "off.yaml", "--log", "after.csv", "-q", "-o", "judged"});
  EXPECT_EQ(resultOf("judged").at("verdict"), "confirmed") << resultOf("judged").at("sentence");
  EXPECT_THAT(text("judged/predictions.csv"), HasSubstr("time_s,measured,00 current-bias"));
  EXPECT_THAT(text("judged/report.html"), HasSubstr("What is left: measured - predicted"));
  // The same log without the change being told: the bias that is gone speaks against the model that holds it.
  succeed({"intervene", "d", "--log", "after.csv", "-q", "-o", "untold"});
  EXPECT_NE(resultOf("untold").at("verdict"), "confirmed");
  // Nobody asks whether the load was doubled.
  const ProcessResult loaded =
      simgap({"intervene", "d", "--change", "load.yaml", "--log", "after.csv", "-o", "loaded"});
  EXPECT_THAT(loaded.err, HasSubstr("twice the load: the log shows by itself what became of the load"));

  succeed({"design", "--separate", "d", "--speeds", "1,2", "--loads", "1,2", "-q", "-o", "next"});
  const Json next = resultOf("next");
  EXPECT_EQ(next.at("protocols").size(), 4u);
  EXPECT_THAT(next.at("sentence").get<std::string>(), HasSubstr("odds beyond 1e+09 to 1 at least"));
  EXPECT_THAT(text("next/next_log.csv"), HasSubstr("time_s"));
  EXPECT_THAT(text("next/next_log.csv"), Not(HasSubstr("motor_current")))
      << "the current of the log before belongs to another speed and load";
  EXPECT_THAT(text("next/report.html"), HasSubstr("What each motion is expected to tell"));
}

TEST_F(InterveneLog, ChoosesWithinLimitsOfCurrentAndDuration) {
  succeed({"design", "--separate", "d", "--speeds", "1,2", "--loads", "1,2", "--max-duration-s", "100", "-q", "-o",
           "short"});
  const Json brief = resultOf("short");  // the log lasts 120 s
  EXPECT_EQ(brief.at("best").at("speed"), 2.0);
  for (const Json& one : brief.at("protocols")) EXPECT_EQ(one.at("beyond").is_null(), one.at("speed") == 2.0) << one;
  succeed(
      {"design", "--separate", "d", "--speeds", "1", "--loads", "0.5,2", "--max-current-A", "15", "-q", "-o", "weak"});
  const Json weak = resultOf("weak");
  EXPECT_EQ(weak.at("best").at("load"), 0.5);
  EXPECT_THAT(weak.at("protocols").at(1).at("beyond").get<std::string>(), HasSubstr(" A"));
  EXPECT_THAT(text("weak/report.html"), HasSubstr("beyond: "));
  expectRefused({"design", "--separate", "d", "--max-current-A", "0.1", "-o", "x"}, 2, "is beyond the limits");
  expectRefused({"design", "--separate", "d", "--max-tension-N", "10", "-o", "x"}, 2,
                "found --max-tension-N with a diagnosis of a log");
}

// A piece of the log that found the cause, by another clock.
TEST_F(InterveneLog, RowsThatFoundTheCauseDoNotConfirmIt) {
  const std::string all = text("log.csv"), head = firstLines(all, 1);
  put("piece.csv", head + all.substr(firstLines(all, 2001).size()));
  expectRefused({"intervene", "d", "--log", "piece.csv", "-o", "x"}, 3, "rows that the diagnosis in d has seen");
}

TEST_F(InterveneLog, RefusesWhatItCannotUse) {
  put("after.csv", "time_s,motor_voltage_V,motor_velocity_rad_s,external_torque_Nm\n0,1,1,1\n0.02,1,1,1\n");
  expectRefused({"intervene", "d", "--log", "after.csv", "-o", "x"}, 3, "after.csv");
  expectRefused({"intervene", "d", "--poses", "poses.csv", "-o", "x"}, 2,
                "found --poses or --motions with a diagnosis of a log");
  expectRefused({"intervene", "d", "--change", "off.yaml", "--change", "load.yaml", "--log", "log.csv", "-o", "x"}, 2,
                "found 2 files of --change with --log");
  put("wrong.yaml", "format: simgap/change/1\nchanges: [{kind: gain, factor: -1}]\n");
  expectRefused({"intervene", "d", "--change", "wrong.yaml", "-o", "x"}, 2, "wrong.yaml:2");
  expectRefused({"design", "--separate", "d", "--poses", "poses.csv", "-o", "x"}, 2, "found MODEL or --poses with");
  expectRefused({"design", "--separate", "d", "--count", "3", "-o", "x"}, 2, "found --count with a diagnosis of a log");
  expectRefused({"design", "-o", "x"}, 2, "found no MODEL or no --poses");
  put("d/candidates/candidates.yaml", replaced(text("d/candidates/candidates.yaml"), "freedom: ", "freedom: -"));
  expectRefused({"intervene", "d", "--change", "off.yaml", "-o", "x"}, 2, "candidates.yaml");
}

}  // namespace
}  // namespace simgap::test
