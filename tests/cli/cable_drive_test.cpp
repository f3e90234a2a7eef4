// A drive with a cable as a user meets it: its friction found from a log, its path followed, what is refused.
#include <vector>

#include "cli/cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class CableDriveCliTest : public CliTest {
 protected:
  CableDriveCliTest() {
    for (const char* file : {"drive.yaml", "classic.yaml", "variant-a.yaml", "variant-b.yaml"}) {
      put(file, readText(sourceFile(std::string("data/cable-drive/") + file)));
    }
    put("path.csv", "time_s,position_deg\n0,0\n1,20\n2,0\n6,0\n");
  }
  Arguments simulate(const std::string& commands, const Arguments& more = {}) const {
    Arguments all{"simulate", "drive.yaml", "--commands", commands, "--hold", "linear", "-q", "-o", "run"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Json result() const { return readJson(path("run/result.json")); }
  void edit(const char* from, const char* to) {
    put("drive.yaml", replaced(readText(sourceFile("data/cable-drive/drive.yaml")), from, to));
  }
};

TEST_F(CableDriveCliTest, FollowsAPathWithEveryCompensation) {
  const std::string told = unwrapped(succeed(simulate("path.csv")));
  EXPECT_THAT(told, testing::HasSubstr("6 s of bowden-joint. Without compensation it misses its reference"));
  const Json json = result();
  EXPECT_EQ(json.at("format"), "simgap/simulate-drive/1");
  ASSERT_EQ(json.at("compensations").size(), 5U);
  const CsvTable tracking = CsvTable::load(path("run/tracking.csv"));
  EXPECT_EQ(tracking.rows(), 601U);  // 6 s at 100 Hz
  EXPECT_EQ(tracking.columns().size(), 3U + 4U * 5U);
  EXPECT_THAT(text("run/report.html"), testing::HasSubstr("Angle of the joint"));
  EXPECT_NE(text("run/run.json").find("variant-a.yaml"), std::string::npos);
}

TEST_F(CableDriveCliTest, RepeatsToTheLastByteWithAnyNumberOfThreads) {
  succeed(simulate("path.csv", {"--threads", "1"}));
  const std::string one = text("run/tracking.csv");
  succeed(simulate("path.csv", {"--force"}));
  EXPECT_EQ(text("run/tracking.csv"), one);
}

/// Without compensation the current is the torque's by k_a alone, from set-points that are up to 20 ms old (3 N m/s).
TEST_F(CableDriveCliTest, GivesATorque) {
  put("torque.csv", "time_s,torque_Nm,external_torque_Nm\n0,0,0\n2,3,0\n4,-3,0\n6,0,0\n");
  succeed(simulate("torque.csv"));
  const Json json = result();
  EXPECT_EQ(json.at("commanded"), "torque");
  EXPECT_GT(json.at("compensations")[3].at("current_rms_A"), json.at("compensations")[0].at("current_rms_A"));
  EXPECT_FALSE(json.at("compensations")[0].contains("rest"));
  const CsvTable tracking = CsvTable::load(path("run/tracking.csv"));
  const std::vector<double> told = tracking.quantity("told", "Nm"), current = tracking.quantity("none_current", "A");
  constexpr double kPerAmpere = 1.300981474136361;  // k_a of variant-b.yaml
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_NEAR(kPerAmpere * current[i], told[i], 0.061) << i;
}

TEST_F(CableDriveCliTest, RefusesWithASentence) {
  expectRefused({"simulate", "drive.yaml", "-o", "run"}, 2, "found no --commands");
  expectRefused(simulate("path.csv", {"--start", "zero"}), 2, "expected no --serve, --config, --measured or --start");
  put("both.csv", "time_s,position_rad,torque_Nm\n0,0,0\n1,0,0\n");
  expectRefused(simulate("both.csv"), 3, "found a position and a torque, expected position_rad or torque_Nm");
  put("neither.csv", "time_s,angle_rad\n0,0\n1,0\n");
  expectRefused(simulate("neither.csv"), 3, "found no command, expected position_rad or torque_Nm");
  put("short.csv", "time_s,position_rad\n0,1\n");
  expectRefused(simulate("short.csv"), 3, "one row of commands");
  put("schedule.yaml", "format: simgap/schedule/1\njoint:\n  position: {segments: [{hold_Nm: 1, for_s: 2}]}\n");
  expectRefused({"simulate", "drive.yaml", "--commands", "schedule.yaml", "-o", "run"}, 2, "expected one");
  edit("{name: classic, model: classic.yaml", "{name: classic, model: nowhere.yaml");
  expectRefused(simulate("path.csv"), 2, "nowhere.yaml");
  edit("name: variant-a", "name: classic");
  expectRefused(simulate("path.csv"), 2, "found a second compensation called classic");
  edit("name: too-much", "name: too much");
  expectRefused(simulate("path.csv"), 2, "expected letters, digits, - and _");
  edit("direction: measured", "direction: backwards");
  expectRefused(simulate("path.csv"), 2, "backwards");
  edit("set_point_rate_Hz: 50", "set_point_rate_Hz: 9000");
  expectRefused(simulate("path.csv"), 2, "expected set_point_rate_Hz of at most rate_Hz");
  edit("rate_Hz: 8000", "rate_Hz: 1000\n  observer_rad_s: 900");
  expectRefused(simulate("path.csv"), 2, "found observer_rad_s: 900, expected at most half of rate_Hz");
  edit("stiffness_Nm_rad: 1500", "stiffness_Nm_rad: 1.0e+12");
  const ProcessResult blown = simgap(simulate("path.csv"));
  EXPECT_EQ(blown.exit_code, 4);
  EXPECT_THAT(blown.err, testing::HasSubstr("the drive blew up"));
  edit("share: 1.2", "gain: 1.2");
  expectRefused(simulate("path.csv"), 2, "gain");
  edit("", "");
  put("classic.yaml", replaced(text("variant-a.yaml"), "predicts: effort", "predicts: load"));
  expectRefused(simulate("path.csv"), 2, "found a model with predicts: load, expected effort");
  put("classic.yaml", replaced(text("variant-a.yaml"), "k_a: {value: 1.3", "k_a: {value: -1.3"));
  expectRefused(simulate("path.csv"), 2, "found a friction law with values below 0");
}

}  // namespace
}  // namespace simgap::test
