// A torso of two arms, calibrated in steps: --only, poses of one arm, each step from the model of the one before.
#include "cli_fixture.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/yaml.h"

namespace simgap::test {
namespace {

using testing::StartsWith;

class TorsoTest : public CliTest {
 protected:
  TorsoTest() {
    for (const char* file :
         {"arm.yaml", "poses_right.csv", "poses_left.csv", "poses_both.csv", "poses_all.csv", "poses_validation.csv"}) {
      put(std::string("torso_") + file, readText(sourceFile(std::string("data/torso/") + file)));
    }
  }
  Json calibrate(const std::string& model, const std::string& poses, const std::string& directory,
                 const Arguments& more) const {
    Arguments all{"calibrate", model, "--poses", poses, "--verify", "none", "--starts", "2", "-q", "-o", directory};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return Json::parse(text(directory + "/result.json"));
  }
};

TEST_F(TorsoTest, IsCalibratedInSteps) {
  const Json right = calibrate("torso_arm.yaml", "torso_poses_right.csv", "right", {"--only", "muscles.r_*"});
  EXPECT_EQ(right.at("parameters").size(), 99u);
  for (const Json& parameter : right.at("parameters")) {
    EXPECT_THAT(parameter.at("name").get<std::string>(), StartsWith("muscles.r_"));
  }
  // The left arm's numbers stay as they were.
  const std::string left_muscle = "- name: l_biceps";
  const auto muscle = [&](const std::string& file) {
    const std::string all = text(file);
    const std::size_t from = all.find(left_muscle);
    return all.substr(from, all.find("spindle_radius_m", from) - from);
  };
  succeed({"convert", "torso_arm.yaml", "same.yaml"});
  EXPECT_EQ(muscle("right/model.yaml"), muscle("same.yaml"));

  calibrate("right/model.yaml", "torso_poses_left.csv", "left", {"--only", "muscles.l_*"});
  const Json both =
      calibrate("left/model.yaml", "torso_poses_both.csv", "both", {"--validation", "torso_poses_validation.csv"});
  EXPECT_EQ(both.at("parameters").size(), 198u);
  succeed({"validate", "torso_arm.yaml", "--poses", "torso_poses_validation.csv", "--evaluator", "equilibrium", "-q",
           "-o", "drawn"});
  const Json drawn = Json::parse(text("drawn/result.json")).at("mje_deg");
  for (const auto& [joint, error] : both.at("mje_deg").at("validation").at("final").items()) {
    EXPECT_LT(error.get<double>(), 0.5 * drawn.at(joint).get<double>()) << joint;
  }
}

TEST_F(TorsoTest, OnlyNamesParametersOfTheConfiguration) {
  const Json some = calibrate("torso_arm.yaml", "torso_poses_right.csv", "some", {"--only", "*.r_biceps.kite_line_*"});
  ASSERT_EQ(some.at("parameters").size(), 1u);
  EXPECT_EQ(some.at("parameters")[0].at("name"), "muscles.r_biceps.kite_line_length_m");
  expectRefused(
      {"calibrate", "torso_arm.yaml", "--poses", "torso_poses_right.csv", "--only", "muscles.x_*", "-q", "-o", "none"},
      2, "muscles.x_*");
}

TEST_F(TorsoTest, ASubTaskSeesItsPosesOfAFileAlone) {
  const std::string parameter = "muscles.r_b*.kite_line_length_m";
  const Json own = calibrate("torso_arm.yaml", "torso_poses_right.csv", "own", {"--only", parameter});
  const Json of_all =
      calibrate("torso_arm.yaml", "torso_poses_all.csv", "of_all", {"--only", parameter, "--only-poses", "r*"});
  EXPECT_EQ(of_all.at("parameters"), own.at("parameters"));
  EXPECT_EQ(of_all.at("mje_deg"), own.at("mje_deg"));
  expectRefused(
      {"calibrate", "torso_arm.yaml", "--poses", "torso_poses_all.csv", "--only-poses", "right_*", "-q", "-o", "none"},
      3, "torso_poses_all.csv: found no pose whose name matches 'right_*'");
}

}  // namespace
}  // namespace simgap::test
