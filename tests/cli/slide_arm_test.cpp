// Arms with slides, and every kind that simgap/arm/2 knows, through validate, calibrate, design and diagnose.
#include <fmt/format.h>

#include <cmath>
#include <random>

#include "cli/cli_fixture.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/run_directory.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/gantry.h"
#include "support/many_kinds.h"

namespace simgap::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kConfig = R"(format: simgap/calibration/1
parameters:
  - {pattern: "muscles.*.kite_line_length_m", step: 2.0e-3, prior_sd: 10.0e-3}
  - {pattern: "muscles.*.shock_cord.stiffness_N_m", step: 25, lower: 1, upper: 1.0e+4, prior_sd_percent: 15}
  - {pattern: "muscles.*.spindle_radius_m", step: 5.0e-5, lower: 5.0e-3, upper: 1.0e-2, prior_sd_percent: 5}
evaluator: equilibrium
optimizer: lm
verify: none
starts: 3
capture_sd_deg: 0.2
slide_sd_mm: 0.5
)";

class SlideArm : public CliTest {
 protected:
  /// Poses of a gantry with 0.5 mm and 0.2 deg of noise. \param mm  of the rail's column, per metre
  std::string poses(const Gantry& gantry, int count, unsigned seed, const std::string& column = "rail_m",
                    double per_metre = 1.0) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shaft(0.0, 8.0);
    std::normal_distribution<double> normal;
    std::string text = "pose,shaft_left_rad,shaft_right_rad,shaft_turner_rad," + column + ",pivot_rad\n";
    for (int p = 0; p < count; ++p) {
      const double l = 2.0 + shaft(random), r = 2.0 + shaft(random), t = shaft(random);
      const double x = gantry.rail(l, r) + 0.5e-3 * normal(random);
      text += fmt::format("p{:02d},{},{},{},{},{}\n", p, l, r, t, per_metre * x,
                          gantry.pendulum(t) + 0.2 * kDegree * normal(random));
    }
    return text;
  }
  void record() const {
    const Gantry real{0.308, 0.313, -0.068, 440.0, 270.0};
    put("gantry.yaml", Gantry{}.yaml());
    put("seen.csv", poses(real, 20, 1));
    put("unseen.csv", poses(real, 15, 2));
    put("config.yaml", kConfig);
  }
  Json result(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
};

TEST_F(SlideArm, ErrorsOfASlideAreInMillimetresInEveryCommand) {
  record();
  const std::string printed = succeed({"calibrate", "gantry.yaml", "--poses", "seen.csv", "--validation", "unseen.csv",
                                       "--config", "config.yaml", "-q", "-o", "out"});
  EXPECT_THAT(printed, AllOf(HasSubstr("rail [mm]"), HasSubstr("pivot")));
  const Json found = result("out");
  EXPECT_FALSE(found.at("mje_deg").at("validation").at("final").contains("rail"));
  const Json& slide = found.at("mje_mm").at("validation");
  EXPECT_GT(slide.at("initial").at("rail").get<double>(), 3.0);
  EXPECT_LT(slide.at("final").at("rail").get<double>(), 0.8) << "0.4 mm are noise";
  EXPECT_GT(found.at("mje_deg").at("validation").at("initial").at("pivot").get<double>(), 1.0);
  EXPECT_LT(found.at("mje_deg").at("validation").at("final").at("pivot").get<double>(), 0.4) << "0.16 deg are noise";
  const Json& predicted = found.at("predicted_mje_mm").at("validation").at("rail");
  EXPECT_GT(predicted.at("mean").get<double>(), 0.3);
  EXPECT_LT(predicted.at("mean").get<double>(), 0.8);
  EXPECT_THAT(text("out/errors.csv"), HasSubstr("rail_error_before_mm,rail_error_after_mm,pivot_error_before_deg"));
  EXPECT_THAT(text("out/history.csv"), HasSubstr("mje_rail_mm,mje_pivot_deg"));
  EXPECT_THAT(text("out/report.html"), HasSubstr("mm (rail)"));

  const Arguments judge{"validate", "out/model.yaml", "--poses", "unseen.csv", "-q", "--force", "-o", "judged"};
  const auto with = [&](Arguments more) {
    more.insert(more.begin(), judge.begin(), judge.end());
    return more;
  };
  EXPECT_THAT(succeed(with({"--max-mje", "0.5", "--max-mje-mm", "0.8"})), HasSubstr("mje_mm of rail"));
  EXPECT_EQ(simgap(with({"--max-mje-mm", "0.1"})).exit_code, 1);
  EXPECT_EQ(result("judged").at("poses")[0].at("error_mm").size(), 1u);
  succeed({"design", "out/model.yaml", "--poses", "seen.csv", "--config", "config.yaml", "--count", "2", "-q", "-o",
           "next"});
  EXPECT_TRUE(result("next").at("predicted_mje_mm").at("after").contains("rail"));
  EXPECT_THAT(text("next/next_poses.csv"), HasSubstr("rail_m,pivot_rad"));
}

TEST_F(SlideArm, IsDiagnosedAndSilentWhereNothingIsHidden) {
  record();
  succeed({"diagnose", "gantry.yaml", "--poses", "seen.csv", "--config", "config.yaml", "-q", "-o", "why"});
  EXPECT_EQ(result("why").at("verdict"), "nothing-found");
  EXPECT_THAT(text("why/evidence.csv"), HasSubstr("error of rail [mm] against joint rail [m]"));
}

TEST_F(SlideArm, ColumnsInMillimetresAreReadByNameAndElseNamed) {
  record();
  put("mm.csv", poses({}, 10, 3, "rail_mm", 1e3));
  put("wrong.csv", poses({}, 10, 3, "rail_m", 1e3));
  const auto validate = [](const std::string& poses) {
    return Arguments{"validate", "gantry.yaml", "--poses", poses, "--evaluator", "equilibrium", "-q", "-o", "v"};
  };
  succeed(validate("mm.csv"));
  EXPECT_LT(result("v").at("mje_mm").at("rail").get<double>(), 0.8);
  expectRefused(validate("wrong.csv"), 3, "it looks like millimetres: name the column rail_mm");
}

/// Poses that the model with other lines rests in, with noise: what every command does with a kind, not how well it is
/// found.
class EveryKind : public CliTest {
 protected:
  void runAll(const std::string& arm, double longest_shaft) const {
    const ArmModel model = readArm(YamlNode::parse(arm, "arm.yaml"));
    put("kinds.yaml", arm);
    ArmModel real = model;  // its lines are longer and shorter by turns
    for (std::size_t m = 0; m < real.muscles.size(); ++m) real.muscles[m].kite_line_length += m % 2 ? 6e-3 : -6e-3;
    EquilibriumArm equilibrium(real);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> shaft(0.0, longest_shaft);
    std::normal_distribution<double> normal;
    std::string table = "pose";
    for (const Muscle& muscle : model.muscles) table += ",shaft_" + muscle.name + "_rad";
    for (const Joint& joint : model.joints) {
      for (const std::string& column : positionColumns(joint.type, joint.name)) table += "," + column;
    }
    for (int p = 0; p < 14;) {
      std::vector<double> shafts(model.muscles.size());
      for (double& angle : shafts) angle = shaft(random);
      if (!equilibrium.solve(shafts).stable) continue;
      table += fmt::format("\np{}", p++);
      for (const double angle : shafts) table += fmt::format(",{}", angle);
      for (std::size_t j = 0; j < model.joints.size(); ++j) {
        JointPosition seen = equilibrium.joints()[j];
        seen.angle += (model.joints[j].slides() ? 5e-4 : 3e-3) * normal(random);
        const double z = normal(random), y = normal(random), x = normal(random);
        const Eigen::Vector3d turn(3e-3 * x, 3e-3 * y, 3e-3 * z);
        seen.rotation = (seen.rotation * expSo3(turn)).normalized();
        for (const double cell : kindOf(model.joints[j].type).cells(seen)) table += fmt::format(",{}", cell);
      }
    }
    put("poses.csv", table + "\n");
    put("config.yaml", kConfig);
    succeed({"validate", "kinds.yaml", "--poses", "poses.csv", "--evaluator", "equilibrium", "-q", "-o", "v"});
    succeed({"calibrate", "kinds.yaml", "--poses", "poses.csv", "--config", "config.yaml", "-q", "-o", "c"});
    const Json calibrated = Json::parse(text("c/result.json"));
    EXPECT_EQ(calibrated.at("delivered"), "calibrated");
    EXPECT_TRUE(calibrated.at("converged").get<bool>());
    for (const auto& [joint, error] : calibrated.at("mje_deg").at("calibration").at("final").items()) {
      EXPECT_LT(error.get<double>(), 1.0) << joint;
    }
    succeed(
        {"design", "c/model.yaml", "--poses", "poses.csv", "--config", "config.yaml", "--count", "1", "-q", "-o", "d"});
    succeed({"diagnose", "kinds.yaml", "--poses", "poses.csv", "--config", "config.yaml", "--effects",
             "gravity-tilt,payload,pulley-friction,ligament-rest-length", "-q", "-o", "w"});
    EXPECT_FALSE(Json::parse(text("w/result.json")).at("verdict").get<std::string>().empty());
  }
  /// The gantry with something instead of its pendulum's spring, or something more.
  static std::string gantryWith(const std::string& from, const std::string& to, const std::string& more = "") {
    std::string text = Gantry{}.yaml();
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    return text + more;
  }
};

using SlowEveryKind = EveryKind;
TEST_F(SlowEveryKind, AllTogether) { runAll(kManyKinds, 9.0); }
TEST_F(EveryKind, CoupledJoint) {
  runAll(gantryWith("spring: {stiffness_Nm_rad: 0.6, rest_rad: 0.2}",
                    "follows: {joint: rail, ratio: 3, offset_rad: 0.1}, coulomb_friction_Nm: 0.02"),
         8.0);
}
TEST_F(EveryKind, Ligament) {
  runAll(gantryWith(
             "", "",
             "tendons:\n  - {name: band, kind: ligament, attachments: [{body: frame, point_m: [0, 0, 0.2]}, "
             "{body: pendulum, point_m: [0, 0, -0.1]}], rest_length_m: 0.29, stiffness_N_m: 100, damping_Ns_m: 1}\n"),
         8.0);
}
TEST_F(EveryKind, SpringAndConstantForce) {
  runAll(
      gantryWith("", "",
                 "tendons:\n  - {name: coil, kind: spring, attachments: [{body: frame, point_m: [-0.3, 0, -0.2]}, "
                 "{body: pendulum, point_m: [0, 0, -0.1]}], rest_length_m: 0.3, stiffness_N_m: 20, damping_Ns_m: 1}\n"
                 "  - {name: weight, kind: constant-force, attachments: [{body: frame, point_m: [0.3, 0, -0.2]}, "
                 "{body: pendulum, point_m: [0, 0, -0.1]}], force_N: 1.5}\n"),
      8.0);
}
TEST_F(EveryKind, LimitedBall) {
  const std::string ball = gantryWith(
      "type: revolute, parent: carriage, child: pendulum, parent_position_m: [0, 0, 0], child_position_m: "
      "[0, 0, 0], axis: [0, 1, 0], lower_limit_rad: -1.5, upper_limit_rad: 1.5, spring: "
      "{stiffness_Nm_rad: 0.6, rest_rad: 0.2}",
      "type: spherical, parent: carriage, child: pendulum, parent_position_m: [0, 0, 0], child_position_m: "
      "[0, 0, 0], limits: {axis: [0, 0, 1], swing_rad: 0.3, lower_twist_rad: -0.2, upper_twist_rad: 0.2, "
      "stiffness_Nm_rad: 5}, spring: {stiffness_Nm_rad: 0.3}");
  runAll(replaced(replaced(ball, "{joint: pivot, radius_m: 0.03}",
                           "{body: frame, point_m: [0.1, 0.1, -0.1]}, {body: pendulum, point_m: [0.01, 0.02, -0.1]}"),
                  "kite_line_length_m: -0.075", "kite_line_length_m: 0.06"),
         4.0);
}

}  // namespace
}  // namespace simgap::test
