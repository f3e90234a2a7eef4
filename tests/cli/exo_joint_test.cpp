// A joint of pneumatic muscles and a motor as a user meets it: fit-pam --joint, simulate, what is refused.
#include "cli/cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class ExoJointCliTest : public CliTest {
 protected:
  ExoJointCliTest() {
    put("joint.yaml", readText(sourceFile("data/exoskeleton/joint.yaml")));
    put("torque.csv", "time_s,torque_Nm\n0,-20\n2,-10\n4,-25\n6,-20\n");
  }
  Arguments simulate(const std::string& commands, const Arguments& more = {}) const {
    Arguments all{"simulate", "joint.yaml", "--commands", commands, "-q", "-o", "run"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Json result() const { return readJson(path("run/result.json")); }
};

TEST_F(ExoJointCliTest, PlaysATorqueWithAndWithoutTendons) {
  succeed(simulate("torque.csv", {"--hold", "linear"}));
  const Json json = result();
  EXPECT_EQ(json.at("format"), "simgap/simulate-joint/1");
  ASSERT_EQ(json.at("controllers").size(), 4U);
  EXPECT_LT(json.at("controllers")[1].at("rms_Nm").get<double>(), json.at("controllers")[3].at("rms_Nm").get<double>());
  const CsvTable tracking = CsvTable::load(path("run/tracking.csv"));
  EXPECT_EQ(tracking.rows(), 601U);  // 6 s at 100 Hz
  EXPECT_EQ(tracking.columns().size(), 6U);
  EXPECT_THAT(text("run/report.html"), testing::HasSubstr("Torque of the muscles alone"));
}

TEST_F(ExoJointCliTest, RepeatsToTheLastByteAndPlaysItsOwnPressures) {
  succeed(simulate("torque.csv", {"--threads", "1"}));
  const std::string motion = text("run/motion.csv");
  succeed(simulate("torque.csv", {"--force"}));
  EXPECT_EQ(text("run/motion.csv"), motion);
  put("pressures.csv", "time_s,pressure_flexor_bar,pressure_extensor_bar,current_A\n0,2,4,0\n1,4,1,2\n3,4,1,2\n");
  succeed(simulate("pressures.csv", {"--force"}));
  EXPECT_EQ(result().at("commanded"), "pressures");
  EXPECT_TRUE(result().at("controllers").empty());
}

/// Valves and motor would cut them off, and the motion be that of other commands.
TEST_F(ExoJointCliTest, RefusesPressuresAndCurrentsBeyondWhatTheJointHas) {
  put("pressures.csv", "time_s,pressure_flexor_kPa,pressure_extensor_kPa\n0,200,300\n1,900,300\n2,900,300\n");
  expectRefused(simulate("pressures.csv"), 3,
                "pressures.csv:3: found a pressure_flexor of 900000 Pa, expected at most the supply's 600000");
  put("current.csv", "time_s,pressure_flexor_bar,pressure_extensor_bar,current_A\n0,6,6,10\n1,6,6,-20\n");
  expectRefused(simulate("current.csv"), 3,
                "current.csv:3: found a current of -20 A, expected at most the limit of 10 either way");
  put("both.csv", "time_s,torque_Nm,pressure_flexor_bar,pressure_extensor_bar\n0,1,6,6\n1,1,6,6\n");
  expectRefused(simulate("both.csv"), 3, "both.csv:1: found torque_Nm and pressure_flexor_Pa, expected a torque, or");
  put("schedule.yaml",
      "format: simgap/schedule/1\njoint:\n  pressure_flexor: {segments: [{hold_bar: 3, for_s: 1}, {hold_bar: 9, for_s: "
      "1}]}\n  pressure_extensor: {segments: [{hold_bar: 3, for_s: 2}]}\n");
  expectRefused(simulate("schedule.yaml"), 2, "at 1 s found a pressure_flexor of 900000 Pa");
}

/// From a raw log to the muscle, and from there to the joint that names it.
TEST_F(ExoJointCliTest, AMuscleFoundFromTheJointsLogGoesIntoTheJoint) {
  put("log.csv.gz", readText(sourceFile("data/exoskeleton/log.csv.gz")));
  succeed({"fit-pam", "log.csv.gz", "--joint", "joint.yaml", "--tied", "-q", "-o", "pam"});
  const Json fit = readJson(path("pam/result.json"));
  EXPECT_EQ(fit.at("model"), "spring");
  const Json& k = fit.at("parameters")[3];
  EXPECT_EQ(k.at("name"), "k");
  EXPECT_LT(k.at("ci95")[0].get<double>(), 33000.0);  // as the sample was made
  EXPECT_GT(k.at("ci95")[1].get<double>(), 33000.0);
  put("joint.yaml",
      replaced(replaced(text("joint.yaml"), "flexor: {diameter_mm: 30, braid_angle_deg: 25, k_N: 40000",
                        "flexor: {model: pam/model.yaml"),
               "extensor: {diameter_mm: 30, braid_angle_deg: 25, k_N: 40000", "extensor: {model: pam/model.yaml"));
  succeed(simulate("torque.csv"));
  EXPECT_NE(text("run/run.json").find("pam/model.yaml"), std::string::npos);
}

/// What a decoder found is what the leg is told.
TEST_F(ExoJointCliTest, ALegStandsUpAsADecoderSays) {
  put("leg.yaml", readText(sourceFile("data/exoskeleton/leg.yaml")));
  put("decoded.csv", "time_s,probability_up,state\n0,0.4,none\n1,0.8,up\n6,0.2,down\n9,0.2,down\n");
  const std::string told = unwrapped(succeed({"simulate", "leg.yaml", "--commands", "decoded.csv", "-q", "-o", "run"}));
  EXPECT_THAT(told, testing::HasSubstr("9 s of standing-leg: with 60 % of the weight borne by the exoskeleton"));
  const Json runs = result().at("runs");
  EXPECT_GT(runs[0].at("standing_share").get<double>(), 0.4);
  EXPECT_EQ(runs[1].at("standing_share"), 0.0);
  EXPECT_THAT(text("run/report.html"), testing::HasSubstr("Torques of the exoskeleton"));
  put("decoded.csv", "time_s,state\n0,up\n1,sideways\n");
  expectRefused({"simulate", "leg.yaml", "--commands", "decoded.csv", "-o", "r"}, 3, "found the state 'sideways'");
}

/// A lever of 7.36 N m under 4.5 and -4.5 N m: 38 degrees, but for 0.3 N m of dry friction (002 fig. 11 and 13).
TEST_F(ExoJointCliTest, AJointGoesUpAndDownAsADecoderSays) {
  put("decoded.csv", "time_s,probability_up,state\n0,0.4,none\n1,0.8,up\n6,0.2,down\n11,0.2,down\n");
  for (const char* file : {"one-dof.yaml", "one-dof-worn.yaml"}) {
    put(file, readText(sourceFile(std::string("data/exoskeleton/") + file)));
    const std::string told =
        unwrapped(succeed({"simulate", file, "--commands", "decoded.csv", "-q", "--force", "-o", "run"}));
    EXPECT_THAT(told, testing::HasSubstr("is on the side it is told to in"));
    const Json json = result();
    EXPECT_EQ(json.at("commanded"), "switch");
    EXPECT_NEAR(json.at("angle_deg").at("highest").get<double>(), 38.0, 6.0) << file;
    EXPECT_NEAR(json.at("angle_deg").at("lowest").get<double>(), -38.0, 6.0) << file;
    EXPECT_GT(json.at("obeyed_percent").get<double>(), 85.0) << file;
  }
  expectRefused({"simulate", "joint.yaml", "--commands", "decoded.csv", "-o", "r"}, 2,
                "found a switch and a joint without one");
  put("one-dof.yaml", replaced(text("one-dof.yaml"), "down_Nm: -4.5", "down_Nm: 4.5"));
  expectRefused({"simulate", "one-dof.yaml", "--commands", "decoded.csv", "-o", "r"}, 2,
                "expected down_Nm below up_Nm");
}

TEST_F(ExoJointCliTest, RefusesWithASentence) {
  expectRefused({"simulate", "joint.yaml", "-o", "run"}, 2, "found no --commands");
  expectRefused({"simulate", "joint.yaml", "--serve"}, 2, "found no arm, expected no --serve");
  expectRefused(simulate("torque.csv", {"--start", "zero"}), 2, "expected no --serve, --config, --measured or --start");
  expectRefused(simulate("torque.csv", {"--step-s", "1e-9"}), 2, "found --step-s 1e-09, expected at least 1e-07");
  put("short.csv", "time_s,torque_Nm\n0,1\n");
  expectRefused(simulate("short.csv"), 3, "one row of commands");
  put("long.csv", "time_s,torque_Nm\n0,1\n1e9,1\n");
  expectRefused(simulate("long.csv"), 2, "expected at most 1e+07 ticks");
  put("bad.csv", "time_s,torque_N\n0,1\n1,1\n");
  expectRefused(simulate("bad.csv"), 3, "torque_N");
  put("schedule.yaml", "format: simgap/schedule/1\njoint:\n  torque: {segments: [{hold_N: 1, for_s: 2}]}\n");
  expectRefused(simulate("schedule.yaml"), 2, "expected one");
  put("joint.yaml",
      replaced(text("joint.yaml"), "flexor: {diameter_mm: 30", "flexor: {model: torque.csv, diameter_mm: 30"));
  expectRefused(simulate("torque.csv"), 2, "torque.csv");
  put("log.csv", "angle_rad,torque_Nm\n0,1\n");
  expectRefused({"fit-pam", "log.csv", "--joint", "joint.yaml", "-o", "p"}, 3, "found neither pressure_flexor_Pa");
  expectRefused({"fit-pam", "log.csv", "--joint", "torque.csv", "-o", "p"}, 2, "torque.csv");
  expectRefused({"fit-pam", "log.csv", "--joint", "joint.yaml", "--model", "m.yaml", "-o", "p"}, 2,
                "found --joint with --model");
}

}  // namespace
}  // namespace simgap::test
