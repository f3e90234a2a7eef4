// `simgap convert`: files in, files out, sentences and exit codes.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using testing::HasSubstr;
using Convert = CliTest;

constexpr const char* kPendulum =
    "<mujoco model='pendulum'>\n<worldbody>\n<site name='top' pos='0.1 0 0'/>\n<body name='rod'>\n"
    "<joint name='pivot' axis='0 1 0' armature='0.01'/>\n<geom type='capsule' fromto='0 0 0 0 0 -0.5' size='0.02'/>\n"
    "<site name='low' pos='0.02 0 -0.3'/>\n</body>\n</worldbody>\n"
    "<tendon><spatial name='line'><site site='top'/><site site='low'/></spatial></tendon>\n"
    "<actuator><position tendon='line' kp='500' forcerange='-1000 0'/></actuator>\n</mujoco>\n";

TEST_F(Convert, AnArmGoesIntoMjcfAndBackAndRestsTheSame) {
  const Json there = Json::parse(succeed({"convert", "arm.yaml", "arm.xml", "--json"}));
  EXPECT_EQ(there["format"], "simgap/convert/1");
  EXPECT_EQ(there["robot"]["muscles"], 11);
  EXPECT_LT(there["read_back"]["largest_turn_at_rest_deg"].get<double>(), 1e-3);
  EXPECT_GE(there["read_back"]["rests"].get<int>(), 10);
  succeed({"convert", "arm.xml", "again.yaml"});
  EXPECT_THAT(text("again.yaml"), HasSubstr("# from arm.xml (MJCF)"));
  // The arm that went there and back is an arm for every command.
  const ProcessResult judged = simgap({"validate", "again.yaml", "--poses", "poses.csv", "-q", "-o", "v"});
  EXPECT_EQ(judged.exit_code, 0) << judged.err;
}

TEST_F(Convert, NamesWhatItLeavesOutAndWritesNoDirectory) {
  put("pendulum.xml", kPendulum);
  const std::string said = unwrapped(succeed({"convert", "pendulum.xml", "pendulum.yaml"}));
  EXPECT_THAT(said, HasSubstr("joint armature: left out"));
  EXPECT_THAT(said, HasSubstr("pendulum.xml:5"));
  EXPECT_TRUE(std::filesystem::exists(path("pendulum.yaml")));
  EXPECT_FALSE(std::filesystem::exists(path("runs")));
  succeed({"convert", "pendulum.xml", "pendulum.urdf"});
  EXPECT_THAT(unwrapped(succeed({"convert", "pendulum.urdf", "bare.yaml"})), HasSubstr("0 muscles"));
}

TEST_F(Convert, TakesMusclesFromAFileOfOurs) {
  put("pendulum.xml", kPendulum);
  succeed({"convert", "pendulum.xml", "pendulum.urdf"});
  const std::string arm = text("arm.yaml");
  put("muscles.yaml",
      arm.substr(arm.find("motor_defaults:"), arm.find("muscles:") - arm.find("motor_defaults:")) +
          "muscles:\n  - name: pull\n    attachments: [{body: world, point_m: [0.1, 0, 0]}, {body: rod, "
          "point_m: [0.02, 0, -0.3]}]\n    kite_line_length_m: 0.2\n    shock_cord: {rest_length_m: 0.08, "
          "stiffness_N_m: 900, damping_Ns_m: 15}\n    spindle_radius_m: 0.006\n");
  const Json result =
      Json::parse(succeed({"convert", "pendulum.urdf", "robot.yaml", "--muscles", "muscles.yaml", "--json"}));
  EXPECT_EQ(result["robot"]["muscles"], 1);
  put("wrong.yaml", replaced(text("muscles.yaml"), "body: rod", "body: bar"));
  expectRefused({"convert", "pendulum.urdf", "other.yaml", "--muscles", "wrong.yaml"}, 2,
                "expected the name of a body");
}

// A whole arm file, of the later version: its lines' surfaces go along.
TEST_F(Convert, TakesTheMusclesOfAWholeArm) {
  put("finger.yaml", readText(sourceFile("data/finger/arm.yaml")));
  succeed({"convert", "finger.yaml", "finger.urdf"});
  const Json result =
      Json::parse(succeed({"convert", "finger.urdf", "robot.yaml", "--muscles", "finger.yaml", "--json"}));
  EXPECT_EQ(result["robot"]["muscles"], 4);
  EXPECT_EQ(result["robot"]["passive_tendons"], 3);
  EXPECT_EQ(result["robot"]["surfaces"], 3);
  EXPECT_THAT(result["remarks"]["read"].dump(), testing::Not(HasSubstr("has its frame elsewhere")));
  // A URDF's links stand at their joints: there the numbers of points mean other places.
  put("low.yaml", replaced(text("arm.yaml"), "[0, 0, -0.28], child_position_m: [0, 0, 0]",
                           "[0, 0, -0.28], child_position_m: [0, 0, 0.02]"));
  succeed({"convert", "low.yaml", "low.urdf"});
  EXPECT_THAT(unwrapped(succeed({"convert", "low.urdf", "moved.yaml", "--muscles", "low.yaml"})),
              HasSubstr("has its frame elsewhere there: points of lines on it are taken by their numbers"));
  put("other.yaml", replaced(text("finger.yaml"), "gearbox_defaults", "gearbox_default"));
  expectRefused({"convert", "finger.urdf", "b.yaml", "--muscles", "other.yaml"}, 2, "other.yaml:");
}

TEST_F(Convert, WritesOverNothingThatItReads) {
  put("part.xml", "<mujocoinclude><body name='rod'><joint/><geom size='.1'/></body></mujocoinclude>\n");
  put("whole.xml", "<mujoco><worldbody><include file='part.xml'/></worldbody></mujoco>\n");
  std::filesystem::create_symlink(path("arm.yaml"), path("same.yaml"));
  for (const char* const same : {"arm.yaml", "./arm.yaml", "same.yaml"}) {
    expectRefused({"convert", "arm.yaml", same, "--force"}, 2, "found the file that is read as the one to write");
  }
  expectRefused({"convert", "whole.xml", "part.xml", "--force"}, 3, "found the file that is read");
  expectRefused({"convert", "whole.xml", "arm.yaml", "--muscles", "arm.yaml", "--force"}, 2,
                "found the file that is read");
}

TEST_F(Convert, WeighsAMeshThatOtherCommandsRefuse) {
  const std::string part =
      "{name: bone, shape: cylinder, radius_m: 0.015, length_m: 0.24, mass_kg: 0.18, position_m: [0, 0, -0.12], axis: "
      "[0, 0, 1]}";
  const std::string drawn = replaced(text("arm.yaml"), "simgap/arm/1", "simgap/arm/2");
  put("drawn.yaml",
      replaced(drawn, part,
               "{name: bone, shape: mesh, file: bone.obj, scale: 0.01, mass_kg: 0.2, position_m: [0, 0, -0.1]}"));
  put("bone.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  succeed({"convert", "drawn.yaml", "whole.yaml"});
  EXPECT_THAT(text("whole.yaml"), HasSubstr("shape: inertia, inertia_kg_m2: ["));
  succeed({"validate", "whole.yaml", "--poses", "poses.csv", "--evaluator", "equilibrium", "-q", "-o", "v"});
  expectRefused({"validate", "drawn.yaml", "--poses", "poses.csv", "-o", "w"}, 2, "'simgap convert FILE NEW.yaml'");
  put("bone.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  expectRefused({"convert", "drawn.yaml", "other.yaml"}, 3, "found an edge of one triangle alone");
}

TEST_F(Convert, ArmsWhoseLinesAllBendOverSomethingCalibrateWithoutAConfig) {
  const std::string wrapped = replaced(
      replaced(kPendulum, "<site site='top'/>", "<site site='top'/><geom geom='wheel'/>"), "<body name='rod'>",
      "<geom name='wheel' type='cylinder' size='0.02 0.1' euler='90 0 0' pos='0.08 0 -0.1'/>\n<body name='rod'>");
  put("wrapped.xml", wrapped);
  succeed({"convert", "wrapped.xml", "wrapped.yaml"});
  put("rests.csv", "pose,shaft_line_rad,pivot_rad\np0,1,0.2\np1,2,0.25\np2,3,0.3\n");
  const ProcessResult built_in = simgap({"calibrate", "wrapped.yaml", "--poses", "rests.csv", "--dry-run"});
  EXPECT_EQ(built_in.exit_code, 0) << built_in.err;
  EXPECT_THAT(unwrapped(built_in.err),
              HasSubstr("configs/calibrate_arm.yaml: left out muscles.*.attachments.1, which this arm does not have"));
  EXPECT_THAT(built_in.out, HasSubstr("muscles.*.attachments.0"));
  // What a user asks for is asked of the arm.
  put("own.yaml", readText(sourceFile("configs/calibrate_arm.yaml")));
  expectRefused({"calibrate", "wrapped.yaml", "--poses", "rests.csv", "--dry-run", "--config", "own.yaml"}, 2,
                "'muscles.*.attachments.1' matches nothing");
}

TEST_F(Convert, ArmsWithoutMusclesCalibrateWithoutAConfig) {
  const std::string damped = replaced(kPendulum, "armature='0.01'", "damping='0.5'");
  put("servo.xml", replaced(damped, "<position tendon='line' kp='500' forcerange='-1000 0'/>",
                            "<position name='servo' joint='pivot' kp='20'/>"));
  succeed({"convert", "servo.xml", "servo.yaml"});
  // The capsule weighs 1 g / cm^3. 18 (target + 0.05 - q) = m g l sin q, where the drawing says 20 and no offset.
  const double mass = std::numbers::pi * 0.02 * 0.02 * (0.5 + 4.0 / 3.0 * 0.02) * 1000.0;
  std::string poses = "pose,target_servo_rad,pivot_rad\n";
  for (int k = 0; k < 12; ++k) {
    const double q = -1.1 + 0.2 * k;
    poses += fmt::format("p{},{},{}\n", k, q - 0.05 + mass * 9.80665 * 0.25 / 18.0 * std::sin(q), q);
  }
  put("rests.csv", poses);
  succeed({"calibrate", "servo.yaml", "--poses", "rests.csv", "-q", "-o", "c"});
  const Json result = Json::parse(text("c/result.json"));
  std::map<std::string, double> found;
  for (const Json& parameter : result["parameters"]) found[parameter["name"]] = parameter["value"];
  EXPECT_NEAR(found.at("tendons.servo.stiffness_Nm_rad"), 18.0, 0.3);
  EXPECT_NEAR(found.at("tendons.servo.offset_rad"), 0.05, 0.003);
}

TEST_F(Convert, CoupledJointsStartWhereTheyAreHeldAndStandWithoutAWarning) {
  put("pair.xml",
      "<mujoco><worldbody>\n<body><joint name='a' axis='0 1 0'/><geom size='0.02' pos='0 0 -0.2'/>\n<body pos='0 0 "
      "-0.2'><joint name='b' axis='0 1 0'/><geom size='0.02' pos='0.03 0 -0.2'/></body></body></worldbody>\n<equality>"
      "<joint joint1='b' joint2='a' polycoef='0 -2'/></equality></mujoco>\n");
  succeed({"convert", "pair.xml", "pair.yaml"});
  put("t.csv", "time_s\n0\n1\n");
  put("start.csv", "pose,a_rad,b_rad\napart,0.3,0.5\nheld,0.3,-0.61\n");
  const auto play = [](const std::string& start, const std::string& pose) {
    Arguments all{"simulate", "pair.yaml", "--commands", "t.csv", "--start", start, "--force", "-o", "out"};
    if (!pose.empty()) all.insert(all.end(), {"--start-pose", pose});
    return all;
  };
  expectRefused(play("start.csv", "apart"), 3,
                "start.csv: pose apart: b_rad: found 0.5, expected -0.6, where its coupling with a holds it");
  succeed(play("start.csv", "held"));
  const std::string rows = text("out/motion.csv");
  EXPECT_THAT(rows.substr(rows.find('\n') + 1, 20), testing::StartsWith("0,0.3,-0.6,")) << "without what it was off";
  const ProcessResult still = simgap(play("rest", ""));
  EXPECT_EQ(still.exit_code, 0);
  EXPECT_EQ(still.err, "");
}

TEST_F(Convert, OtherCommandsAskForTheConversion) {
  put("pendulum.xml", kPendulum);
  put("t.csv", "time_s\n0\n1\n");
  const std::string sentence = "found a robot in XML, expected an arm file: convert it first";
  expectRefused({"validate", "pendulum.xml", "--poses", "poses.csv", "-o", "v"}, 2, sentence);
  expectRefused({"simulate", "pendulum.xml", "--commands", "t.csv", "-o", "s"}, 2, sentence);
}

TEST_F(Convert, RefusesWithOneSentence) {
  put("pendulum.xml", kPendulum);
  put("floating.xml", replaced(kPendulum, "<joint name='pivot' axis='0 1 0' armature='0.01'/>", "<freejoint/>"));
  put("model.sdf", "<?xml version='1.0'?>\n<sdf version='1.9'/>\n");
  put("broken.xml", "<mujoco><worldbody>");
  expectRefused({"convert", "floating.xml", "a.yaml"}, 3, "floating.xml:5: freejoint: found a floating base");
  expectRefused({"convert", "model.sdf", "a.yaml"}, 3, "found no model with joints, expected one");
  expectRefused({"convert", "broken.xml", "a.yaml"}, 3, "found no XML that can be read");
  expectRefused({"convert", "pendulum.xml", "a.obj"}, 2, "found the ending '.obj'");
  expectRefused({"convert", "nothing.xml", "a.yaml"}, 2, "cannot be read");
  put("there.yaml", "mine");
  expectRefused({"convert", "pendulum.xml", "there.yaml"}, 2, "there.yaml: exists; --force replaces it");
  EXPECT_EQ(text("there.yaml"), "mine");
  succeed({"convert", "pendulum.xml", "there.yaml", "--force"});
  EXPECT_THAT(text("there.yaml"), HasSubstr("format: simgap/arm/"));
}

}  // namespace
}  // namespace simgap::test
