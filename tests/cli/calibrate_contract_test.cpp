// What a calibration may hand over, and when it has to say no.
#include <fmt/format.h>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CalibrateContractTest : public CliTest {
 protected:
  CalibrateContractTest() {
    put("all.csv", readText(sourceFile("data/arm/poses_calibration.csv")));
    put("unseen.csv", readText(sourceFile("data/arm/poses_validation.csv")));
  }
  static Arguments plain(const std::string& directory, const Arguments& more = {}) {
    Arguments all{"calibrate", "arm.yaml", "--poses", "all.csv", "-q", "-o", directory};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Json resultOf(const std::string& directory) const { return Json::parse(text(directory + "/result.json")); }
  std::string statusOf(const std::string& directory) const {
    return Json::parse(text(directory + "/run.json")).at("status");
  }
};

/// No shaft arrives within five steps.
std::string hastyConfig() {
  return replaced(replaced(quickConfig(), "acquisition_s: 5", "acquisition_s: 0.01"), "early_acquisition: true",
                  "early_acquisition: false");
}

TEST_F(CalibrateContractTest, WithoutOptionsItDescendsWithPriors) {
  succeed(plain("out", {"--validation", "unseen.csv"}));
  const Json result = resultOf("out");
  EXPECT_EQ(result.at("optimizer"), "lm");
  EXPECT_EQ(result.at("objective"), "posterior");
  EXPECT_EQ(result.at("delivered"), "calibrated");
  EXPECT_TRUE(result.at("failure").is_null());
  EXPECT_EQ(result.at("converged"), true);
  EXPECT_EQ(result.at("valid_poses").at("validation").at("compared"), 15);
  EXPECT_LT(result.at("mje_deg").at("validation").at("final").at("shoulder").get<double>(), 2.0);
}

TEST_F(CalibrateContractTest, ValidatesNothingOnThePosesTheSearchHasSeen) {
  expectRefused(plain("out", {"--validation", "all.csv"}), 3, "all.csv: found 15 of 15 poses with readings");
  put("copy.csv.gz", gzipped(text("all.csv")));
  expectRefused(plain("out", {"--validation", "copy.csv.gz"}), 3, "validates nothing");
}

TEST_F(CalibrateContractTest, SaysHowManyPosesAreCopies) {
  put("twice.csv", std::regex_replace(text("unseen.csv"), std::regex("\\np([^\\n]*)"), "\np$1\nq$1"));
  const ProcessResult result = simgap(plain("out", {"--validation", "twice.csv"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("twice.csv: found 15 different poses of 30"));
}

TEST_F(CalibrateContractTest, OptionsOfAnotherOptimiserAreRefused) {
  expectRefused(plain("out", {"--generations", "9"}), 2,
                "found --generations with --optimizer lm, expected it with --optimizer cma-es or es");
  expectRefused(plain("out", {"--lambda", "9"}), 2, "found --lambda with --optimizer lm");
  expectRefused(plain("out", {"--mu", "3", "--optimizer", "cma-es"}), 2, "found --mu with --optimizer cma-es");
  expectRefused(plain("out", {"--starts", "3", "--optimizer", "es"}), 2, "found --starts with --optimizer es");
  expectRefused(plain("out", {"--objective", "paper"}), 2, "found --objective with --optimizer lm");
}

TEST_F(CalibrateContractTest, ThePapersObjectiveIsSearchedAndSaid) {
  for (const char* objective : {"geodesic", "paper"}) {
    succeed(calibrate(objective, {"--objective", objective}));
    EXPECT_EQ(resultOf(objective).at("objective"), objective);
    EXPECT_THAT(text(std::string(objective) + "/config.resolved.yaml"),
                HasSubstr(std::string("objective: ") + objective));
  }
  EXPECT_LT(resultOf("paper").at("fitness").at("initial").get<double>(),
            resultOf("geodesic").at("fitness").at("initial").get<double>());
  EXPECT_NE(text("paper/model.yaml"), text("geodesic/model.yaml"));
}

TEST_F(CalibrateContractTest, AnAbsurdArmEndsWithASentenceInsteadOfACrash) {
  const std::string arm = text("arm.yaml");
  const std::size_t point = arm.find("point_m: [");
  ASSERT_NE(point, std::string::npos);
  put("arm.yaml", arm.substr(0, point) + "point_m: [99999" + arm.substr(arm.find(',', point)));
  const ProcessResult result = simgap(plain("out"));
  EXPECT_EQ(result.exit_code, 4) << result.signal << result.err;
  EXPECT_THAT(result.err, HasSubstr("p000"));
  EXPECT_EQ(countOf(result.err, "\n"), 1u) << result.err;
}

TEST_F(CalibrateContractTest, AResultWorseThanItsStartIsNeverDelivered) {
  succeed(plain("good"));
  std::filesystem::copy_file(path("good/model.yaml"), path("start.yaml"));
  // One generation from the best known model, with steps ten times too large, can only lead away from it.
  put("config.yaml",
      replaced(replaced(quickConfig(1), "step: 2.0e-3, prior_sd: 7.0e-3", "step: 2.0e-2, prior_sd: 7.0e-3"),
               "step: 2.0e-3, prior_sd: 3.5e-3", "step: 2.0e-2, prior_sd: 3.5e-3"));
  const ProcessResult result =
      simgap({"calibrate", "start.yaml", "--poses", "all.csv", "--config", "config.yaml", "-q", "-o", "out"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("the result is worse than the start, which model.yaml keeps: "),
                                HasSubstr("try --optimizer lm")));
  EXPECT_THAT(statusOf("out"), HasSubstr("failed: the result is worse than the start"));
  EXPECT_EQ(text("out/model.yaml"), text("start.yaml"));
  const Json found = resultOf("out");
  EXPECT_EQ(found.at("delivered"), "start");
  const Json& errors = found.at("mje_deg").at("calibration");
  double before = 0.0, after = 0.0;
  for (const char* joint : {"shoulder", "elbow"}) {
    before += errors.at("initial").at(joint).get<double>();
    after += errors.at("final").at(joint).get<double>();
  }
  EXPECT_GT(after, before);
  EXPECT_THAT(text("out/report.html"), HasSubstr("Failed: the result is worse than the start"));
}

TEST_F(CalibrateContractTest, PosesThatDoNotComeToRestAreNoResult) {
  put("config.yaml", replaced(hastyConfig(), "optimizer: es", "optimizer: lm"));
  const ProcessResult result = simgap(calibrate("out"));
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, AllOf(HasSubstr("3 of 3 poses are invalid: p000: acquisition error"),
                                HasSubstr("--verify none"), HasSubstr("protocol.acquisition_s")));
  EXPECT_THAT(result.out, HasSubstr("calibration (0 of 3 poses)"));
  EXPECT_THAT(statusOf("out"), HasSubstr("failed: "));
  EXPECT_EQ(resultOf("out").at("valid_poses").at("calibration").at("compared"), 0);
  // The flag that is recommended helps.
  succeed(calibrate("statics", {"--verify", "none"}));
  EXPECT_EQ(resultOf("statics").at("valid_poses").at("calibration").at("compared"), 3);
}

TEST_F(CalibrateContractTest, OnlyTheMostProbableParametersAccuseTheModel) {
  const Arguments more{"--validation", "unseen.csv",    "--optimizer", "es",       "--evaluator",
                       "equilibrium",  "--generations", "30",          "--verify", "none"};
  const std::string table = succeed(plain("es", more));
  EXPECT_THAT(table, AllOf(HasSubstr("Not converged: "), HasSubstr("--optimizer lm."),
                           Not(HasSubstr("something is not in the model")), Not(HasSubstr("hardly counted"))));
  const Json result = resultOf("es");
  EXPECT_EQ(result.at("converged"), false);
  EXPECT_GT(result.at("sd_from_optimum").get<double>(), 1.0);
  for (const char* key : {"identifiability", "predicted_mje_deg", "outlying_poses"}) EXPECT_FALSE(result.contains(key));
  EXPECT_TRUE(result.at("parameters")[0].at("sd").is_null());
  const std::string page = text("es/report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("Not converged: "), Not(HasSubstr("something is not in the model")),
                          Not(HasSubstr("missed by more than expected"))));
}

TEST_F(CalibrateContractTest, NumbersInAnotherUnitOrOrderAreNamed) {
  put("odd.csv", replaced(text("all.csv"), "elbow_rad", "elbow_qw"));
  const Arguments odd{"calibrate", "arm.yaml", "--poses", "odd.csv", "-q", "-o", "out"};
  EXPECT_EQ(simgap(odd).exit_code, 3);
  // The columns of x, y, z, w under the names of w, x, y, z.
  put("odd.csv", replaced(text("all.csv"), "shoulder_qw,shoulder_qx,shoulder_qy,shoulder_qz",
                          "shoulder_qz,shoulder_qw,shoulder_qx,shoulder_qy"));
  expectRefused(odd, 3, "found quaternions that look like x, y, z, w (as ROS writes them)");
  // Degrees under the name of radians: what the file says times 57.3.
  Arguments degrees = odd;
  for (const char* muscle :
       {"deltoid_anterior", "deltoid_lateral", "deltoid_posterior", "pectoralis_major", "latissimus_dorsi",
        "infraspinatus", "supraspinatus", "subscapularis", "biceps", "brachialis", "triceps"}) {
    const std::string column = std::string("shaft_") + muscle + "_rad";
    degrees.insert(degrees.end(), {"--map", fmt::format("{0}={0}*57.29577951308232", column)});
  }
  put("odd.csv", text("all.csv"));
  expectRefused(degrees, 3, "look like degrees");
}

}  // namespace
}  // namespace simgap::test
