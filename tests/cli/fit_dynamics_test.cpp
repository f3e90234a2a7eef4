// fit-dynamics and predict on the sample robot, as a user runs them.
#include <fmt/format.h>

#include "cli_fixture.h"
#include "reality/robot_rig.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class FitDynamicsTest : public CliTest {
 protected:
  Json fit(const Arguments& more) const {
    Arguments all{"fit-dynamics", robotFile("robot.urdf"), "--log", robotFile("log.csv.gz"), "-q", "-o", "fit"};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return Json::parse(text("fit/result.json"));
  }
};

TEST_F(FitDynamicsTest, ExplainsWhatOneJointCannot) {
  const Json result = fit({});
  EXPECT_EQ(result.at("format"), "simgap/fit-dynamics/1");
  for (const Json& joint : result.at("joints")) {
    EXPECT_LT(joint.at("error_heldout").get<double>(), 0.5 * joint.at("error_alone").get<double>()) << joint;
    EXPECT_GT(joint.at("resting").get<int>(), 0) << joint;
  }
  for (const Json& body : result.at("bodies")) EXPECT_GT(body.at("smallest_moment").get<double>(), 0.0) << body;
  for (const char* file : {"model.yaml", "arm.yaml", "base_parameters.csv", "parameters.csv", "predictions.csv",
                           "report.html", "config.resolved.yaml"}) {
    EXPECT_TRUE(std::filesystem::exists(path("fit") / file)) << file;
  }
  // The robot it found is an arm that others read.
  succeed({"convert", "fit/arm.yaml", "found.urdf"});
}

TEST_F(FitDynamicsTest, PredictsAnotherTrajectory) {
  fit({});
  succeed({"predict", "fit/model.yaml", "--log", robotFile("other_log.csv.gz"), "-q", "-o", "predicted"});
  succeed({"predict", robotFile("robot.urdf"), robotFile("other_log.csv.gz"), "-q", "-o", "drawn"});
  const Json found = Json::parse(text("predicted/result.json")), drawn = Json::parse(text("drawn/result.json"));
  for (std::size_t c = 0; c < found.at("joints").size(); ++c) {
    EXPECT_LT(found.at("joints")[c].at("relative_error").get<double>(), 0.1);
    EXPECT_GT(drawn.at("joints")[c].at("relative_error").get<double>(), 0.2);
  }
}

TEST_F(FitDynamicsTest, PlaysTheRobotUnderTheEffortsOfALog) {
  fit({});
  const Arguments found{"predict", "fit/model.yaml", robotFile("other_log.csv.gz"), "--simulate", "-q", "-o", "run"};
  const auto worst = [&](Arguments arguments) {
    arguments.emplace_back("--force");
    succeed(arguments);
    double share = 0.0;
    const Json result = Json::parse(text("run/result.json"));
    for (const Json& joint : result.at("joints")) {
      share = std::max(share, joint.at("rms_error").get<double>() / joint.at("range").get<double>());
    }
    return share;
  };
  const auto with = [](Arguments arguments, const std::string& gains) {
    arguments.insert(arguments.end(), {"--gains", gains});
    return arguments;
  };
  const std::string gains = robotFile("gains.yaml");
  const double held = worst(with(found, gains));
  EXPECT_GT(held, 0.0);
  EXPECT_LT(held, 1e-3);
  Arguments drawn = with(found, gains);
  drawn[1] = robotFile("robot.urdf");
  EXPECT_GT(worst(drawn), 1e-2);
  EXPECT_GT(worst(found), 0.1);  // a minute without a controller
  EXPECT_THAT(text("run/prediction.csv"), testing::HasSubstr("j1_predicted_rad,j1_measured_rad"));

  put("other.yaml", replaced(text(gains), "j4:", "j5:"));
  expectRefused(with(found, "other.yaml"), 2, "expected the key 'j4'");
  expectRefused({"predict", "fit/model.yaml", robotFile("other_log.csv.gz"), "--gains", gains, "-o", "x"}, 2,
                "expected --simulate with them");
}

TEST_F(FitDynamicsTest, SeveralLogsAreJudgedByEachOther) {
  const Json result = fit({"--log", robotFile("other_log.csv.gz")});
  EXPECT_EQ(result.at("logs").size(), 2u);
  for (const Json& joint : result.at("joints")) {
    EXPECT_LT(joint.at("error_other_logs").get<double>(), 2.0 * joint.at("error_heldout").get<double>()) << joint;
  }
}

TEST_F(FitDynamicsTest, SameForAnyNumberOfThreads) {
  fit({"--threads", "1"});
  const std::string one = text("fit/result.json"), model = text("fit/model.yaml");
  fit({"--threads", "2", "--force"});
  EXPECT_EQ(text("fit/result.json"), one);
  EXPECT_EQ(text("fit/model.yaml"), model);
}

TEST_F(FitDynamicsTest, WhatCannotBeIsOneSentence) {
  const std::string log = robotFile("log.csv.gz"), robot = robotFile("robot.urdf");
  expectRefused({"fit-dynamics", robot, "--log", log, "--gravity", "0,0,9.81"}, 3, "gravity along");
  expectRefused({"fit-dynamics", robot, "--log", log, "--torque-constants", "1,2"}, 2, "constants with currents only");
  expectRefused({"fit-dynamics", "arm.yaml", "--log", log}, 2, "found a ball");
  put("short.csv", "time_s,j1_rad\n0,0\n");
  expectRefused({"fit-dynamics", robot, "--log", "short.csv"}, 3, "found no torque or current of joint j1");
}

TEST_F(FitDynamicsTest, CurrentsWithAndWithoutALoadTellTorqueConstants) {
  reality::Robot robot = reality::randomRobot(4, 3, false, false);
  reality::RobotRigOptions rig;
  rig.current = true;
  const std::vector<double> constants = {12.0, 8.0, 5.0};
  put("robot.urdf", reality::drawnUrdf(robot, 1));
  put("free.csv", reality::recordRobot(robot, rig, 1, constants));
  reality::RobotLink& link = robot.links.back();  // a point where its centre is changes nothing but its mass
  link.mass += 1.5;
  put("loaded.csv", reality::recordRobot(robot, rig, 2, constants));
  const std::string load = fmt::format("link3,1.5,{},{},{}", link.centre.x(), link.centre.y(), link.centre.z());
  const Arguments free{"fit-dynamics", "robot.urdf", "--log", "free.csv"};
  const auto with = [&](const Arguments& more) {
    Arguments all = free;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  succeed(with({"--loaded-log", "loaded.csv", "--payload", load, "-q", "-o", "fit"}));
  const Json result = Json::parse(text("fit/result.json"));
  for (std::size_t c = 0; c < constants.size(); ++c) {
    const Json& joint = result.at("joints").at(c);
    EXPECT_NEAR(joint.at("torque_constant_Nm_A").get<double>(), constants[c], 0.01 * constants[c]);
    EXPECT_GT(joint.at("torque_constant_sd").get<double>(), 0.0);
    EXPECT_LT(joint.at("error_fitted").get<double>(), 0.05) << "the loaded log is explained, too";
  }
  succeed({"predict", "fit/model.yaml", "--log", "free.csv", "-q", "-o", "predicted"});

  expectRefused(free, 2, "or --payload and --loaded-log");
  expectRefused(with({"--payload", load}), 2, "found --payload without --loaded-log");
  expectRefused(with({"--loaded-log", "loaded.csv"}), 2, "found --loaded-log without --payload");
  expectRefused(with({"--loaded-log", "loaded.csv", "--payload", "link3,heavy,0,0,0"}), 2, "found 'heavy'");
  expectRefused(with({"--loaded-log", "loaded.csv", "--payload", "link3,1.5"}), 2, "expected BODY,MASS,X,Y,Z");
  expectRefused(with({"--loaded-log", "loaded.csv", "--payload", "gripper,1.5,0,0,0"}), 2, "found the body gripper");
  expectRefused(with({"--loaded-log", "loaded.csv", "--payload", "link3,0.0015,0,0,0.1"}), 3, "is it in kg and m?");
}

TEST_F(FitDynamicsTest, DesignsTheMotionToRecord) {
  succeed({"design", "--excite", robotFile("robot.urdf"), robotFile("limits.yaml"), "-q", "-o", "next"});
  const Json result = Json::parse(text("next/result.json"));
  EXPECT_EQ(result.at("format"), "simgap/excitation/1");
  EXPECT_GT(result.at("sd_ratio").at("best_random").get<double>(), 1.0);
  const CsvTable rows = CsvTable::parse(text("next/trajectory.csv"), "trajectory.csv");
  const Json points = Json::parse(text("next/trajectory.json"));
  ASSERT_EQ(points.at("points").size(), rows.rows());
  EXPECT_EQ(points.at("joint_names"), Json::parse(R"(["j1", "j2", "j3", "j4"])"));
  const std::vector<double> time = rows.quantity("time", "s"), angle = rows.quantity("j3", "rad");
  const Json& last = points.at("points").back();
  EXPECT_DOUBLE_EQ(last.at("time_from_start").at("sec").get<double>() +
                       1e-9 * last.at("time_from_start").at("nanosec").get<double>(),
                   time.back());
  EXPECT_DOUBLE_EQ(time.back(), 20.0);
  EXPECT_NEAR(last.at("positions")[2].get<double>(), angle.front(), 1e-9) << "it ends where it began";
  EXPECT_TRUE(std::filesystem::exists(path("next/report.html")));
}

TEST_F(FitDynamicsTest, DesignRefusesWhatItCannotPlay) {
  put("slow.yaml", "format: simgap/excitation-limits/1\nall_joints: {velocity_rad_s: 1}\n");
  expectRefused({"design", "--excite", robotFile("robot.urdf"), "slow.yaml", "-o", "next"}, 2,
                "joint j1: found no acceleration_rad_s2");
  expectRefused({"design", "--excite", robotFile("robot.urdf"), "-o", "next"}, 2, "--excite ROBOT without LIMITS");
  EXPECT_FALSE(std::filesystem::exists(path("next")));
}

}  // namespace
}  // namespace simgap::test
