// Other optimisers and evaluators than the paper's, and the design of poses, as a user runs them.
#include "cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap {
namespace {

using testing::HasSubstr;

class OptimizerTest : public test::CliTest {
 protected:
  OptimizerTest() {
    put("all.csv", test::readText(test::sourceFile("data/arm/poses_calibration.csv")));
    put("unseen.csv", test::readText(test::sourceFile("data/arm/poses_validation.csv")));
  }
  Json run(const test::Arguments& more, const std::string& directory) const {
    test::Arguments arguments{"calibrate",  "arm.yaml", "--poses", "all.csv", "--validation",
                              "unseen.csv", "-q",       "-o",      directory};
    arguments.insert(arguments.end(), more.begin(), more.end());
    succeed(arguments);
    return Json::parse(text(directory + "/result.json"));
  }
};

TEST_F(OptimizerTest, DescentWithPriorsReachesUnseenPosesAndSaysHowSureItIs) {
  const Json result = run({"--optimizer", "lm"}, "lm");
  EXPECT_EQ(result.at("optimizer"), "lm");
  EXPECT_EQ(result.at("evaluator"), "equilibrium");
  EXPECT_EQ(result.at("stop_reason"), "converged");
  // A prototype reached 2.0 and 0.4 deg; the judge is the full Bullet protocol.
  EXPECT_LE(result.at("mje_deg").at("validation").at("final").at("shoulder").get<double>(), 2.0);
  EXPECT_LE(result.at("mje_deg").at("validation").at("final").at("elbow").get<double>(), 0.6);
  EXPECT_EQ(result.at("verification").at("judge"), "bullet");
  EXPECT_LT(result.at("verification").at("sets").at("validation").at("difference_deg").at("mean").at("shoulder"), 0.5);
  EXPECT_EQ(result.at("singular_values").size(), 60u);
  for (const Json& parameter : result.at("parameters")) {
    EXPECT_GT(parameter.at("sd").get<double>(), 0.0);
    EXPECT_LE(parameter.at("sd").get<double>(), 1.0001 * parameter.at("prior_sd").get<double>());
  }
  EXPECT_EQ(succeed({"validate", "lm/model.yaml", "--poses", "unseen.csv", "--evaluator", "equilibrium", "-q", "-o",
                     "v", "--max-mje", "2.5"})
                .substr(0, 1),
            " ");
}

TEST_F(OptimizerTest, RunsAreTheSameForAnyNumberOfThreads) {
  for (const char* optimizer : {"lm", "hybrid"}) {
    run({"--optimizer", optimizer, "--starts", "3", "--threads", "1", "--verify", "none"}, "one");
    run({"--optimizer", optimizer, "--starts", "3", "--threads", "3", "--verify", "none"}, "three");
    EXPECT_EQ(text("one/model.yaml"), text("three/model.yaml")) << optimizer;
    std::filesystem::remove_all(path("one"));
    std::filesystem::remove_all(path("three"));
  }
}

TEST_F(OptimizerTest, EvolutionStrategiesSearchWithEquilibriaToo) {
  for (const char* optimizer : {"es", "cma-es"}) {
    const Json result = run({"--optimizer", optimizer, "--evaluator", "equilibrium", "--generations", "10"}, optimizer);
    EXPECT_EQ(result.at("converged"), false) << "no most probable parameters: nothing is said of their uncertainty";
    EXPECT_EQ(result.at("generations"), 10);
    EXPECT_LT(result.at("mje_deg").at("calibration").at("final").at("shoulder"),
              result.at("mje_deg").at("calibration").at("initial").at("shoulder"));
  }
}

TEST_F(OptimizerTest, AFinishedDescentIsResumedToTheSameResult) {
  run({"--optimizer", "lm", "--starts", "2"}, "lm");
  const std::string model = text("lm/model.yaml");
  succeed({"calibrate", "--resume", "lm", "-q"});
  EXPECT_EQ(text("lm/model.yaml"), model);
}

TEST_F(OptimizerTest, DescentWithoutDerivativesIsRefused) {
  expectRefused({"calibrate", "arm.yaml", "--poses", "all.csv", "--optimizer", "lm", "--evaluator", "bullet"}, 2,
                "needs derivatives");
  expectRefused({"calibrate", "arm.yaml", "--poses", "all.csv", "--optimizer", "gradient"}, 2, "gradient");
}

TEST_F(OptimizerTest, DesignSaysWhichPosesToRecordNext) {
  const std::string table =
      succeed({"design", "arm.yaml", "--poses", "all.csv", "--count", "2", "--candidates", "40", "-q", "-o", "next"});
  EXPECT_THAT(table, HasSubstr("2 random commands instead"));
  const Json result = Json::parse(text("next/result.json"));
  const auto predicted = [&](const char* when) {
    return result.at("predicted_mje_deg").at(when).at("shoulder").at("mean").get<double>();
  };
  EXPECT_LT(predicted("after"), predicted("before"));
  EXPECT_EQ(test::countOf(text("next/next_poses.csv"), "\n"), 3u);
  expectRefused({"design", "arm.yaml", "--poses", "poses.csv", "-o", "few"}, 3, "expected at least 8");
}

}  // namespace
}  // namespace simgap
