// What the program prints and writes, and what it must not.
#include <algorithm>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class OutputTest : public CliTest {};

TEST_F(OutputTest, HelpShowsAnExample) {
  for (const Arguments& arguments :
       std::vector<Arguments>{{"--help"}, {"calibrate", "--help"}, {"validate", "--help"}}) {
    const ProcessResult result = simgap(arguments);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    EXPECT_THAT(result.out, HasSubstr("  simgap " + (arguments.size() > 1 ? arguments[0] : "calibrate") + " "));
    EXPECT_THAT(result.out, HasSubstr("Usage: simgap"));
  }
  const std::string version = succeed({"--version"});
  EXPECT_THAT(version, StartsWith("simgap 0."));
  EXPECT_EQ(countOf(version, "\n"), 1u);
}

TEST_F(OutputTest, JsonPrintsExactlyTheResultFile) {
  std::string out = succeed({"validate", "arm.yaml", "--poses", "poses.csv", "--json", "-o", "v"});
  EXPECT_EQ(out, text("v/result.json"));
  out = succeed(calibrate("c", {"--json", "--generations", "1"}));
  EXPECT_EQ(out, text("c/result.json"));
  out = succeed({"calibrate", "--resume", "c", "--json"});
  EXPECT_EQ(out, text("c/result.json"));
}

TEST_F(OutputTest, OptionsNobodyGaveLeaveTheConfigurationAlone) {
  const auto resolved = [&](const std::string& config, const Arguments& more) {
    put("config.yaml", config);
    Arguments arguments = calibrate("out", {"--generations", "1", "--force"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    succeed(arguments);
    return text("out/config.resolved.yaml");
  };
  const std::string early = quickConfig(1);
  const std::string fixed = replaced(early, "early_acquisition: true", "early_acquisition: false");
  const std::string yes = "early_acquisition: true\n", no = "early_acquisition: false\n";
  EXPECT_THAT(resolved(early, {}), HasSubstr(yes));
  EXPECT_THAT(resolved(fixed, {}), HasSubstr(no));
  EXPECT_THAT(resolved(early, {"--no-early-acquisition"}), HasSubstr(no));
  EXPECT_THAT(resolved(fixed, {"--early-acquisition"}), HasSubstr(yes));
  EXPECT_THAT(resolved(early, {"--seed", "18446744073709551615"}), HasSubstr("seed: 18446744073709551615\n"));
  EXPECT_THAT(resolved(early, {"--mu", "1", "--lambda", "3", "--target-fitness", "0.5"}),
              HasSubstr("mu: 1\n  lambda: 3\n  generations: 1\n  seed: 1\n  target_fitness: 0.5\n"));
}

TEST_F(OutputTest, StdoutHoldsResultsOnly) {
  put("poses.csv", replaced(text("poses.csv"), "1.71763311", "nan"));
  for (const char* how : {"-v", "-q"}) {
    const ProcessResult result =
        simgap({"validate", "arm.yaml", "--poses", "poses.csv", "--skip-bad-rows", "--json", how, "-o", how + 1});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.out, text(std::string(how + 1) + "/result.json"));
    EXPECT_THAT(result.err, HasSubstr("poses.csv: 1 bad rows left out\n"));
  }
  const std::string table = succeed({"validate", "arm.yaml", "--poses", "poses.csv", "--skip-bad-rows", "-o", "t"});
  EXPECT_THAT(table, HasSubstr("mean joint error [deg], 2 of 2 poses"));
  EXPECT_THAT(table, HasSubstr("report: t/report.html\n"));
}

TEST_F(OutputTest, DryRunWritesNothing) {
  const auto before = everything();
  EXPECT_THAT(succeed({"validate", "arm.yaml", "--poses", "poses.csv", "--dry-run"}), HasSubstr("nothing was written"));
  const std::string plan = unwrapped(succeed(calibrate("out", {"--dry-run"})));
  EXPECT_THAT(plan, HasSubstr("99 parameters on 3 poses with bullet by es: 6 generations of 8 individuals (2 parents), "
                              "144 pose simulations"));
  EXPECT_THAT(plan, HasSubstr("the poses tell, of 99 parameters: "));
  EXPECT_EQ(everything(), before);
  put("config.yaml", replaced(quickConfig(), "muscles.*.attachments.0", "muscles.*.wings"));
  expectRefused(calibrate("out", {"--dry-run"}), 2, "matches nothing");
}

TEST_F(OutputTest, DirectoryHoldsAllThatTheContractNames) {
  succeed(calibrate("c", {"--generations", "1", "--validation", "others.csv"}));
  EXPECT_THAT(entries(path("c")),
              ElementsAre("arm_bodies.csv", "arm_muscles.csv", "arm_parts.csv", "config.resolved.yaml", "errors.csv",
                          "history.csv", "inputs", "log.txt", "model.yaml", "parameters.csv", "report.html",
                          "result.json", "run.json", "state.json"));
  const Json run = Json::parse(text("c/run.json"));
  EXPECT_EQ(run.at("format"), "simgap/run/1");
  EXPECT_EQ(run.at("status"), "done");
  EXPECT_EQ(run.at("argv")[1], "calibrate");
  EXPECT_EQ(run.at("inputs").size(), 4u);
  EXPECT_EQ(run.at("inputs")[0].at("sha256"), sha256(text("arm.yaml")));
  // The calibrated model is a model for every command.
  succeed({"validate", "c/model.yaml", "--poses", "poses.csv", "--config", "config.yaml", "-q", "-o", "v"});
  const Json after = Json::parse(text("c/result.json")).at("mje_deg").at("calibration").at("final");
  EXPECT_EQ(Json::parse(text("v/result.json")).at("mje_deg"), after);
}

TEST_F(OutputTest, ReportIsMadeAgainFromTheFilesAlone) {
  succeed(calibrate("c", {"--generations", "1", "--validation", "others.csv"}));
  const std::string first = text("c/report.html");
  for (const char* name : {"arm.yaml", "poses.csv", "config.yaml", "c/report.html"})
    std::filesystem::remove(path(name));
  std::filesystem::rename(path("c"), path("moved"));
  EXPECT_EQ(succeed({"report", "moved"}), "report: moved/report.html\n");
  EXPECT_EQ(text("moved/report.html"), first);
  expectRefused({"report", "nowhere"}, 2, "nowhere: is no run directory");
  put("moved/result.json", "{\"format\": \"simgap/calibrate/1\"}");
  expectRefused({"report", "moved"}, 3, "moved/result.json: is no complete result");
  std::filesystem::remove(path("moved/result.json"));
  expectRefused({"report", "moved"}, 2, "moved: found no result.json");
}

TEST_F(OutputTest, WithoutADirectoryItMakesOneUnderRuns) {
  for (int i = 0; i < 3; ++i) succeed({"validate", "arm.yaml", "--poses", "poses.csv", "-q"});
  const auto runs = entries(path("runs"));
  ASSERT_EQ(runs.size(), 3u);
  for (const std::string& run : runs) EXPECT_THAT(run, StartsWith("validate-20"));
}

TEST_F(OutputTest, ForceReplacesARunDirectory) {
  const Arguments validate{"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "out"};
  succeed(validate);
  put("out/left.txt", "over");
  const Json first = Json::parse(text("out/result.json"));
  put("poses.csv", firstLines(text("poses.csv"), 3));
  expectRefused(validate, 2, "out: exists");
  Arguments forced = validate;
  forced.push_back("--force");
  succeed(forced);
  EXPECT_FALSE(std::filesystem::exists(path("out/left.txt")));
  EXPECT_NE(Json::parse(text("out/result.json")), first);
  // Bad input leaves the old run as it is, --force or not.
  put("poses.csv", "");
  expectRefused(forced, 3, "empty file");
}

TEST_F(OutputTest, NamesOfPosesChangeNothingButNames) {
  const auto errorsOf = [&](const std::string& poses, const std::string& out) {
    put("named.csv", poses);
    succeed({"validate", "arm.yaml", "--poses", "named.csv", "-q", "-o", out});
    return text(out + "/errors.csv");
  };
  const std::string poses = text("poses.csv");
  const std::string plain = errorsOf(poses, "plain");
  const auto renamed = [](const std::string& csv, const std::string& name) { return replaced(csv, "p001", name); };
  int n = 0;
  for (const char* name : {"zz", "\"a,b\"", "</script>", "12", "\"line\nbreak\"", "\"say \"\"hi\"\"\"", "\xFF\xFE"}) {
    EXPECT_EQ(errorsOf(renamed(poses, name), "out" + std::to_string(++n)), renamed(plain, name));
  }
}

TEST_F(OutputTest, MapsColumnsAndReadsGzip) {
  const std::string poses = text("poses.csv");
  succeed({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "plain"});
  put("odd.csv", replaced(replaced(poses, "elbow_rad", "odd elbow"), "pose,", "who,"));
  // What follows an entry is the model, not another entry.
  succeed({"validate", "--map", "elbow_rad=odd elbow", "--map", "pose=who", "arm.yaml", "--poses", "odd.csv", "-q",
           "-o", "mapped"});
  EXPECT_EQ(text("mapped/result.json"), text("plain/result.json"));
  put("packed.csv.gz", gzipped(poses));
  succeed({"validate", "arm.yaml", "--poses", "packed.csv.gz", "-q", "-o", "packed"});
  EXPECT_EQ(text("packed/result.json"), text("plain/result.json"));
}

TEST_F(OutputTest, CalibratesBitIdenticallyWithAnyNumberOfThreads) {
  std::string first;
  for (const char* threads : {"1", "2", "4"}) {
    const std::string out = std::string("t") + threads;
    succeed(calibrate(out, {"--threads", threads, "--validation", "others.csv"}));
    if (first.empty()) first = found(out);
    EXPECT_EQ(found(out), first) << threads;
  }
  succeed(calibrate("other", {"--seed", "2", "--validation", "others.csv"}));
  EXPECT_NE(found("other"), first);
  EXPECT_LT(std::filesystem::file_size(path("t1/report.html")), 1'500'000u);  // with the arm in three dimensions
}

}  // namespace
}  // namespace simgap::test
