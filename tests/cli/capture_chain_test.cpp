// The whole chain from images of a known arm to a calibrated model.
#include "cli/capture_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/rotation.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Renders an arm that stands in its equilibria (found from its energy alone), captures it, and calibrates a model
/// whose lines are wrong on the captured poses.
class ChainTest : public CaptureTest {
 protected:
  static constexpr int kPoses = 6;
  static constexpr int kFramesPerRest = 8;

  ChainTest() {
    for (const char* side : {"left", "right"}) {
      fs::remove_all(path(side));
      fs::create_directory(path(side));
    }
    put("rig.yaml",
        "format: simgap/rig/1\nstereo: stereo.yaml\ntargets: targets.yaml\njoints:\n"
        "  - {name: joint1, type: spherical, parent: torso, child: humerus}\n"
        "  - {name: joint2, type: revolute, parent: humerus, child: forearm, axis: [1, 0, 0]}\n");
    renderRests();
  }

  static bool inView(const reality::ArmPose& pose) {
    const reality::StereoLenses& lenses = stage().lenses();
    for (const auto& target : reality::markersInLeft(stage().targets(), pose)) {
      for (const Eigen::Vector3d& p : target) {
        const Eigen::Vector2d l = lenses.left.project(p);
        const Eigen::Vector2d r = lenses.right.project(lenses.rotation * p + lenses.translation);
        for (const Eigen::Vector2d& v : {l, r}) {
          if (v.x() < 10 || v.y() < 10 || v.x() > 630 || v.y() > 470) return false;
        }
      }
    }
    return true;
  }

  void renderRests() {
    const reality::Arm arm = reality::referenceArm();
    std::string shafts = "time_s";
    for (std::size_t m = 0; m < arm.muscles.size(); ++m) shafts += ",shaft_" + reality::muscleName(int(m)) + "_rad";
    shafts += "\n";
    int frame = 0;
    std::optional<reality::ArmPose> last;
    for (std::uint64_t seed = 1; poses_ < kPoses; ++seed) {
      const std::vector<double> angles = reality::randomShafts(arm, seed);
      const reality::Equilibrium rest = reality::followFromRest(arm, angles);
      const reality::ArmPose pose{Eigen::Quaterniond(rest.configuration[0].rotation), rest.configuration[1].angle};
      if (!rest.converged || !inView(pose)) continue;
      ++poses_;
      const int moving = last ? 3 : 0;
      for (int f = -moving; f < kFramesPerRest; ++f, ++frame) {
        put(frame, {0.0, 2}, {f < 0 ? reality::between(*last, pose, 1.0 + f / 4.0) : pose});
        shafts += std::to_string(frame / 60.0);
        for (const double angle : angles) shafts += "," + std::to_string(angle);
        shafts += "\n";
      }
      last = pose;
    }
    put("shafts.csv", shafts);
    put("true.yaml", reality::toYaml(arm, {.coulomb = false}));
    reality::Arm wrong = arm;
    for (std::size_t m = 0; m < wrong.muscles.size(); ++m) wrong.muscles[m].kite_line += m % 2 == 0 ? 0.006 : -0.006;
    put("wrong.yaml", reality::toYaml(wrong, {.coulomb = false}));
  }

  int poses_ = 0;
};

TEST_F(ChainTest, RenderCaptureCalibrateValidate) {
  // A patient protocol: without Coulomb friction the joints swing long.
  put("chain.yaml",
      "format: simgap/calibration/1\nparameters:\n  - {pattern: \"muscles.*.kite_line_length_m\", step: 3.0e-3}\n"
      "strategy: {mu: 3, lambda: 12, generations: 12, seed: 3}\n"
      "protocol: {step_s: 0.002, acquisition_s: 5, settle_s: 20, steady_s: 0.1, max_shaft_error_deg: 5, "
      "max_velocity_rad_s: 0.05, early_acquisition: true}\nevaluator: bullet\noptimizer: es\ncapture_sd_deg: 0.1\n");
  succeed(capture({"--rate", "60", "--shafts", "shafts.csv"}));
  ASSERT_EQ(CsvTable::load(path("out/poses.csv")).rows(), std::size_t(kPoses));
  const auto errors = [&](const std::string& model, const std::string& directory) {
    succeed({"validate", model, "--poses", "out/poses.csv", "--config", "chain.yaml", "-q", "-o", directory});
    const Json mje = Json::parse(text(directory + "/result.json")).at("mje_deg");
    return mje.at("joint1").get<double>() + mje.at("joint2").get<double>();
  };
  const double of_truth = errors("true.yaml", "v-true");
  const double before = errors("wrong.yaml", "v-wrong");
  succeed({"calibrate", "wrong.yaml", "--poses", "out/poses.csv", "--config", "chain.yaml", "-q", "-o", "calibrated"});
  const double after = errors("calibrated/model.yaml", "v-after");
  std::printf("joint errors, shoulder + elbow [deg]: true model %.2f, wrong model %.2f, calibrated %.2f\n", of_truth,
              before, after);
  // The true model rests where the cameras saw the arm: what is left is capture noise and the protocol's end speed.
  EXPECT_LT(of_truth, 1.0);
  EXPECT_GT(before, 5.0 * of_truth);
  EXPECT_LT(after, 0.8 * before);
}

}  // namespace
}  // namespace simgap::test
