// Arms with slides and coupled joints in motion: simulate, validate --motions, calibrate --motions, against Lagrange's
// equations of a cart with a pendulum (support/gantry.h).
#include <fmt/format.h>

#include <cmath>
#include <random>

#include "cli/cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"
#include "support/gantry.h"

namespace simgap::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kHeld = 10.0;         // friction of the gears: no cord turns them [N m]
constexpr double kRailSd = 0.3e-3;     // [m]
constexpr double kPivotSd = 2.0e-3;    // [rad]
constexpr double kFrame = 1.0 / 60.0;  // [s]

/// What a movement begins with: shafts that are held, joints away from where they rest.
struct Release {
  double left, right, wheel, rail, pivot;
};
Release release(const Gantry& gantry, int draw) {
  const double phase = 1.3 * draw, rail = 0.06 * std::cos(phase);
  return {4.0 + std::sin(phase), 5.0 + std::cos(2.0 * phase), 6.0 + 2.0 * std::sin(1.7 * phase), rail,
          gantry.ratio == 0.0 ? 0.9 * std::cos(phase + 1.0) : 0.1 + gantry.ratio * rail};
}

class SlideMotion : public CliTest {
 protected:
  /// A gantry's movement: the tables that a rig would log, and what a motion set says of it.
  std::string record(const Gantry& gantry, const std::string& name, int draw, bool in_millimetres = false) const {
    const Release r = release(gantry, draw);
    put(name + "_muscles.csv",
        fmt::format("time_s,setpoint_left_rad,setpoint_right_rad,setpoint_turner_rad\n0,{0},{1},{2}\n1,{0},{1},{2}\n",
                    r.left, r.right, r.wheel));
    std::mt19937 random(static_cast<unsigned>(draw) + 1U);
    std::normal_distribution<double> normal;
    std::string joints = in_millimetres ? "time_s,rail_mm,pivot_deg\n" : "time_s,rail_m,pivot_rad\n";
    const auto states = gantry.play({r.rail, r.pivot, 0.0, 0.0}, r.left, r.right, r.wheel, kFrame, 61);
    for (std::size_t f = 0; f < states.size(); ++f) {
      const double rail = states[f].rail + kRailSd * normal(random),
                   pivot = states[f].pivot + kPivotSd * normal(random);
      joints += fmt::format("{},{},{}\n", static_cast<double>(f) * kFrame, in_millimetres ? 1e3 * rail : rail,
                            in_millimetres ? toDegrees(pivot) : pivot);
    }
    put(name + "_joints.csv", joints);
    return fmt::format(
        "  - {{name: {0}, muscles: {0}_muscles.csv, joints: {0}_joints.csv, start: {{joints: {{rail_m: {1}, pivot_rad: "
        "{2}}}, shafts: {{left_rad: {3}, right_rad: {4}, turner_rad: {5}}}}}}}\n",
        name, r.rail, r.pivot, r.left, r.right, r.wheel);
  }
  void recordSet(const Gantry& gantry, const std::string& file, int first, int count) const {
    std::string set = "format: simgap/motions/1\nmotions:\n";
    for (int i = first; i < first + count; ++i) set += record(gantry, fmt::format("m{}", i), i, i % 2 == 1);
    put(file, set);
  }
  CsvTable table(const std::string& name) const { return CsvTable::load(path(name)); }
  Json resultOf(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }

  /// Largest difference between `simulate` and Lagrange's equations: rail [m], pivot [rad].
  std::pair<double, double> apart(const Gantry& gantry, int draw, const char* step = "0.001") const {
    put("gantry.yaml", gantry.yaml(kHeld));
    const Release r = release(gantry, draw);
    put("start.csv", fmt::format("shaft_left_rad,shaft_right_rad,shaft_turner_rad,rail_mm,pivot_deg\n{},{},{},{},{}\n",
                                 r.left, r.right, r.wheel, 1e3 * r.rail, toDegrees(r.pivot)));
    put("hold.csv", fmt::format("time_s,setpoint_left_rad,setpoint_right_rad,setpoint_turner_rad\n0,{},{},{}\n", r.left,
                                r.right, r.wheel));
    succeed({"simulate", "gantry.yaml", "--commands", "hold.csv", "--start", "start.csv", "--duration-s", "1",
             "--step-s", step, "-q", "--force", "-o", "run"});
    const CsvTable motion = table("run/motion.csv");
    const auto rail = motion.quantity("rail", "m"), pivot = motion.quantity("pivot", "rad");
    const auto states = gantry.play({r.rail, r.pivot, 0.0, 0.0}, r.left, r.right, r.wheel, 0.01, rail.size());
    std::pair<double, double> largest{0.0, 0.0};
    for (std::size_t row = 0; row < rail.size(); ++row) {
      largest.first = std::max(largest.first, std::abs(rail[row] - states[row].rail));
      largest.second = std::max(largest.second, std::abs(pivot[row] - states[row].pivot));
    }
    return largest;
  }
};

// Cords that become taut jump to what their dampers do: first order in the step.
TEST_F(SlideMotion, ASlideWithAPendulumMovesAsLagrangeSays) {
  for (const int draw : {0, 1, 2}) {
    const auto [rail, pivot] = apart({.rail_viscous = 4.0, .pivot_viscous = 0.01}, draw, "0.0001");
    EXPECT_LT(rail, 2e-5) << draw;
    EXPECT_LT(toDegrees(pivot), 0.01) << draw;
  }
}

TEST_F(SlideMotion, APendulumThatFollowsItsSlideMovesAsLagrangeSays) {
  for (const int draw : {0, 1, 2}) {
    const auto [rail, pivot] = apart({.rail_viscous = 4.0, .pivot_viscous = 0.01, .ratio = 3.0}, draw, "0.0001");
    EXPECT_LT(rail, 2e-5) << draw;
    EXPECT_LT(toDegrees(pivot), 0.01) << draw;
  }
}

TEST_F(SlideMotion, WhatIsToldOfASlideIsInMillimetres) {
  apart({}, 1);
  const Json first = resultOf("run").at("joints");
  EXPECT_NEAR(first.at("rail").at("first_mm").get<double>(), 1e3 * release({}, 1).rail, 1e-6);
  EXPECT_GT(first.at("rail").at("fastest_m_s").get<double>(), 0.05);
  EXPECT_TRUE(first.at("pivot").contains("first_deg"));
  put("sensors.yaml",
      "format: simgap/simulation/1\nsensors:\n  joints: {rate_Hz: 60, noise_deg: 0.1, slide_noise_mm: 0.5}\n");
  Arguments again{"simulate", "gantry.yaml", "--commands",   "hold.csv", "--start", "start.csv", "--duration-s",
                  "1",        "--config",    "sensors.yaml", "-q",       "-o",      "seen"};
  succeed(again);
  again.back() = "ghost";
  again.insert(again.end(), {"--measured", "seen/joints.csv"});
  EXPECT_THAT(succeed(again), AllOf(HasSubstr("rail"), HasSubstr("mm"), HasSubstr("m/s")));
  EXPECT_NEAR(resultOf("ghost").at("joints").at("rail").at("measured_rms_mm").get<double>(), 0.5, 0.15);
  EXPECT_THAT(text("ghost/measured.csv"),
              HasSubstr("rail_measured_mm,rail_simulated_mm,rail_error_mm,pivot_measured_deg"));
  EXPECT_THAT(text("ghost/report.html"), HasSubstr("way from the zero pose [mm]"));
}

TEST_F(SlideMotion, IsCalibratedAndJudgedInMillimetres) {
  const Gantry real{.left = 0.302, .right = 0.319, .rail_viscous = 28.0, .pivot_viscous = 0.03};
  put("gantry.yaml", Gantry{}.yaml(kHeld));
  recordSet(real, "seen.yaml", 0, 5);
  recordSet(real, "unseen.yaml", 5, 4);
  put("config.yaml", R"(format: simgap/calibration/1
parameters:
  - {pattern: "muscles.*.kite_line_length_m", step: 5.0e-4, prior_sd: 3.0e-3}
  - {pattern: "joints.*.viscous_friction_*", step: 5.0e-3, lower: 1.0e-4, upper: 1.0e+3, prior_sd_percent: 40}
)");
  const std::string printed = succeed({"calibrate", "gantry.yaml", "--motions", "seen.yaml", "--validation-motions",
                                       "unseen.yaml", "--config", "config.yaml", "-q", "-o", "out"});
  EXPECT_THAT(printed, AllOf(HasSubstr("rail [mm]"), HasSubstr("pivot [deg]")));
  const Json result = resultOf("out");
  EXPECT_EQ(result.at("delivered"), "calibrated");
  EXPECT_NEAR(result.at("noise").at("rail_mm").get<double>(), 1e3 * kRailSd, 0.05);
  const Json& unseen = result.at("motion_rms").at("validation");
  EXPECT_GT(unseen.at("initial").at("rail_mm").get<double>(), 3e3 * kRailSd);
  EXPECT_LT(unseen.at("final").at("rail_mm").get<double>(), 1.2e3 * kRailSd);
  EXPECT_LT(unseen.at("final").at("pivot_deg").get<double>(), 1.2 * toDegrees(kPivotSd));
  for (const auto& [name, truth] : std::map<std::string, double>{{"joints.rail.viscous_friction_Ns_m", 28.0},
                                                                 {"joints.pivot.viscous_friction_Nms", 0.03}}) {
    const auto p = std::ranges::find_if(result.at("parameters"),
                                        [&name = name](const Json& one) { return one.at("name") == name; });
    ASSERT_NE(p, result.at("parameters").end()) << name;
    EXPECT_NEAR(p->at("value").get<double>(), truth, 3.0 * p->at("sd").get<double>()) << name;
    EXPECT_LT(p->at("sd").get<double>(), 0.1 * truth) << name;
  }
  EXPECT_THAT(text("out/report.html"), HasSubstr("joint error [mm]"));
  const Arguments judge{"validate", "out/model.yaml", "--motions",   "unseen.yaml", "-q", "--force",
                        "-o",       "judged",         "--max-rms-mm"};
  const auto with = [&](const char* limit) {
    Arguments all = judge;
    all.emplace_back(limit);
    return all;
  };
  EXPECT_THAT(succeed(with("0.4")), HasSubstr("rms_mm of rail"));
  EXPECT_EQ(simgap(with("0.1")).exit_code, 1);
  EXPECT_EQ(resultOf("judged").at("motions").at(0).at("channels").at(0).at("unit"), "mm");
}

TEST_F(SlideMotion, IsServedAndFollowsTargets) {
  put("gantry.yaml", Gantry{}.yaml());
  put("lines", "{\"commands\": {\"left\": {\"setpoint_rad\": 9}}, \"advance_s\": 0.05}\n");
  const ProcessResult served =
      runProcess({"/bin/sh", "-c", std::string(SIMGAP_BINARY) + " simulate gantry.yaml --serve < lines"}, path(""));
  const Json answer = Json::parse(served.out);
  EXPECT_EQ(answer.at("joint_velocities_m_s").size(), 1U);
  EXPECT_LT(answer.at("joint_velocities_m_s").at("rail").get<double>(), 0.0) << "the left cord draws it to the left";
  EXPECT_FALSE(answer.at("joint_velocities_rad_s").contains("rail"));
  put("targets.csv", "time_s,target_rail_mm,target_pivot_deg\n0,0,5\n1,0,5\n1.5,25,-5\n3,25,-5\n");
  succeed({"simulate", "gantry.yaml", "--commands", "targets.csv", "--hold", "linear", "-q", "-o", "run"});
  const CsvTable motion = table("run/motion.csv");
  EXPECT_NEAR(motion.quantity("rail", "m").back(), 0.025, 1.5e-3);
}

TEST_F(SlideMotion, AMotionThatStartsMovingIsToldInItsUnit) {
  put("gantry.yaml", Gantry{}.yaml());
  std::string joints = "time_s,rail_m,pivot_rad\n";
  for (int f = 0; f < 30; ++f) joints += fmt::format("{},{},0.1\n", f * kFrame, 0.2 * f * kFrame);
  put("joints.csv", joints);
  put("muscles.csv", "time_s,setpoint_left_rad,setpoint_right_rad,setpoint_turner_rad\n0,1,1,1\n1,1,1,1\n");
  put("set.yaml", "format: simgap/motions/1\nmotions:\n  - {name: m, muscles: muscles.csv, joints: joints.csv}\n");
  expectRefused({"validate", "gantry.yaml", "--motions", "set.yaml", "-q", "-o", "v"}, 3,
                "motion m starts moving: found rail at 200 mm/s");
}

}  // namespace
}  // namespace simgap::test
