// Every exit code of the command line contract but 70, which is a bug.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

class ExitCodeTest : public CliTest {
 protected:
  Arguments validate(const Arguments& more = {}) const {
    Arguments all{"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "out"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

/// No shaft arrives within five steps.
std::string briefConfig() {
  return replaced(replaced(quickConfig(), "acquisition_s: 5", "acquisition_s: 0.01"), "early_acquisition: true",
                  "early_acquisition: false");
}

TEST_F(ExitCodeTest, ZeroWhenDone) {
  EXPECT_EQ(simgap(validate({"--max-mje", "90"})).exit_code, 0);
  EXPECT_EQ(Json::parse(text("out/run.json")).at("status"), "done");
}

TEST_F(ExitCodeTest, OneWhenACriterionFails) {
  const ProcessResult result = simgap(validate({"--max-mje", "0.5"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, testing::ContainsRegex("mje_deg of elbow +0\\.5 +[0-9.]+ +FAIL"));
  const Json criteria = Json::parse(text("out/result.json")).at("criteria");
  ASSERT_EQ(criteria.size(), 2u);
  EXPECT_EQ(criteria[0].at("pass"), false);
}

TEST_F(ExitCodeTest, TwoForWrongUsage) {
  expectRefused({}, 2, "subcommand");
  expectRefused({"frobnicate"}, 2, "");
  expectRefused({"validate"}, 2, "required");
  expectRefused({"validate", "arm.yaml"}, 2, "--poses");
  expectRefused({"calibrate"}, 2, "calibrate needs MODEL and --poses, or --resume");
  expectRefused({"calibrate", "arm.yaml"}, 2, "calibrate needs MODEL and --poses");
  expectRefused(validate({"--frobnicate"}), 2, "--frobnicate");
  expectRefused(validate({"--max-mje"}), 2, "--max-mje");
  expectRefused(validate({"--max-mje", "-3"}), 2, "--max-mje: found -3, expected a number above 0");
  expectRefused(validate({"another.yaml"}), 2, "another.yaml");
  for (const char* bad : {"x", "0", "-1", "nan", "inf", "1e999"})
    expectRefused(validate({"--max-mje", bad}), 2, "--max-mje");
  for (const char* bad : {"x", "-1", "1.5", "5000"}) expectRefused(validate({"--threads", bad}), 2, "--threads");
  for (const char* bad : {"x", "-1", "1.5", "18446744073709551616"}) {
    expectRefused(validate({"--seed", bad}), 2, "--seed");
  }
  for (const char* bad : {"noequals", "=x", "x="}) expectRefused(validate({"--map", bad}), 2, "--map: found");
  for (const char* bad : {"0", "-3", "x", "1.5", "99999999999"})
    expectRefused(calibrate("out", {"--generations", bad}), 2, "");
  for (const char* bad : {"nan", "inf", "x"})
    expectRefused(calibrate("out", {"--target-fitness", bad}), 2, "--target-fitness");
  expectRefused(calibrate("out", {"--mu", "9"}), 2, "lambda = 8 is not an integer >= mu = 9");
}

TEST_F(ExitCodeTest, TwoForFilesThatCannotBeRead) {
  expectRefused({"validate", "nothing.yaml", "--poses", "poses.csv"}, 2, "nothing.yaml: cannot be read");
  expectRefused({"validate", "arm.yaml", "--poses", "nothing.csv"}, 2, "nothing.csv: cannot be read");
  expectRefused({"validate", ".", "--poses", "poses.csv"}, 2, ".: found a directory, expected a file");
  expectRefused(validate({"--config", "nothing.yaml"}), 2, "nothing.yaml: cannot be read");
  expectRefused(calibrate("out", {"--validation", "nothing.csv"}), 2, "nothing.csv: cannot be read");
  expectRefused({"validate", "two\nlines.yaml", "--poses", "poses.csv"}, 2, "two lines.yaml: cannot be read");
}

TEST_F(ExitCodeTest, TwoForAWrongModelOrConfiguration) {
  put("bad.yaml", replaced(text("arm.yaml"), "mass_kg: 0.31", "mass_kg: 0"));
  expectRefused({"validate", "bad.yaml", "--poses", "poses.csv"}, 2, "bad.yaml:8: bodies[1].parts[0].mass_kg: found 0");
  put("bad.yaml", "{");
  expectRefused({"validate", "bad.yaml", "--poses", "poses.csv"}, 2, "bad.yaml:");
  const auto refuseConfig = [&](const std::string& from, const std::string& to, const std::string& sentence) {
    put("config.yaml", replaced(quickConfig(), from, to));
    expectRefused(calibrate("out"), 2, sentence);
  };
  refuseConfig("mu: 2", "nu: 2", "config.yaml:13: strategy.nu: found an unknown key");
  refuseConfig("muscles.*.attachments.0", "muscles.*.wings", "pattern 'muscles.*.wings' matches nothing in the model");
  refuseConfig("upper: 1.0e-2", "upper: 5.5e-3", "outside its range");
  refuseConfig("lower: 5.0e-3", "lower: 5", "config.yaml:11: parameters[4]: lower 5 is above upper");
}

TEST_F(ExitCodeTest, TwoForADirectoryThatIsNotOursToWrite) {
  put("out/precious.txt", "mine");
  expectRefused(validate(), 2, "out: exists; --force replaces it");
  expectRefused(validate({"--force"}), 2, "--force leaves it alone");
  put("file", "mine");
  expectRefused({"validate", "arm.yaml", "--poses", "poses.csv", "-o", "file"}, 2, "file: exists and is no directory");
  expectRefused({"validate", "arm.yaml", "--poses", "poses.csv", "-o", "file/out"}, 2, "cannot be made");
  expectRefused(calibrate("/proc/simgap"), 2, "cannot be made");
}

TEST_F(ExitCodeTest, TwoForAResumeThatCannotBe) {
  expectRefused({"calibrate", "--resume", "nowhere"}, 2, "nowhere: is no run directory");
  succeed({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", "validated"});
  expectRefused({"calibrate", "--resume", "validated"}, 2, "inputs.json");
  expectRefused({"calibrate", "arm.yaml", "--resume", "validated"}, 2, "leave out MODEL");
  for (const Arguments& extra : std::vector<Arguments>{{"--poses", "poses.csv"},
                                                       {"--seed", "2"},
                                                       {"--generations", "9"},
                                                       {"--force"},
                                                       {"-o", "other"},
                                                       {"--map", "a=b"}}) {
    Arguments arguments{"calibrate", "--resume", "validated"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    expectRefused(arguments, 2, "leave out " + (extra[0] == "-o" ? "--output" : extra[0]));
  }
}

TEST_F(ExitCodeTest, ThreeForEveryKindOfBadPoses) {
  const std::string good = text("poses.csv");
  const std::string header = firstLines(good, 1);
  const auto refuse = [&](const std::string& poses, const std::string& sentence) {
    put("poses.csv", poses);
    expectRefused(validate(), 3, sentence);
    expectRefused(calibrate("out"), 3, sentence);
  };
  refuse("", "poses.csv:1: found an empty file");
  refuse(header, "poses.csv: found no rows");
  refuse(replaced(good, "shaft_biceps_rad", "other"), "poses.csv:1: found no column shaft_biceps_rad");
  refuse(replaced(good, "shaft_biceps_rad", "shaft_wing_rad"), "the model has no muscle 'wing'");
  refuse(replaced(good, "elbow_rad", "elbow_N"), "poses.csv:1: column elbow_N");
  refuse(replaced(good, "repeat", "pose"), "poses.csv:1: found the column pose twice");
  refuse(replaced(good, "0.970530989", "0.99"), "poses.csv:3: quaternion of joint shoulder: found length 1.01");
  refuse(replaced(good, "1.71763311", "nan"), "poses.csv:3: column elbow_rad: found 'nan'");
  refuse(replaced(good, "1.71763311", "inf"), "poses.csv:3: column elbow_rad: found 'inf'");
  refuse(replaced(good, "1.71763311", ""), "poses.csv:3: column elbow_rad: found an empty cell");
  refuse(replaced(good, "1.71763311", "bent"), "poses.csv:3: column elbow_rad: found 'bent'");
  refuse(replaced(good, ",1.71763311", ""), "poses.csv:3: found 18 cells, expected 19");
  refuse(replaced(good, "p001", "p000"), "poses.csv:3: pose p000 repeat 0 stands twice");
  refuse(replaced(replaced(good, "p000", "\"p\n0\""), "p001", "\"p\n0\""),
         "poses.csv:4: pose p 0 repeat 0 stands twice");
  refuse(replaced(good, "p001", "\"p001"), "found a quoted cell without an end");
  refuse(gzipped(good).substr(0, 100), "the gzip data break off here");
}

TEST_F(ExitCodeTest, ThreeForBadValidationPosesToo) {
  put("bad.csv", firstLines(text("poses.csv"), 1));
  expectRefused(calibrate("out", {"--validation", "bad.csv"}), 3, "bad.csv: found no rows");
  expectRefused(validate({"--map", "pose=nothing"}), 3, "poses.csv:1: found no column nothing to read as pose");
}

TEST_F(ExitCodeTest, FourWhenNoIndividualIsValid) {
  put("config.yaml", briefConfig());
  const ProcessResult result = simgap(calibrate("out"));
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, ::testing::StartsWith("simgap: no valid individual in generation 1: 8 x acquisition error "
                                                "(worst: acquisition error of "));
  EXPECT_EQ(countOf(result.err, "\n"), 1u) << result.err;
  EXPECT_FALSE(std::filesystem::exists(path("out/result.json")));
  EXPECT_THAT(Json::parse(text("out/run.json")).at("status").get<std::string>(),
              ::testing::StartsWith("failed: no valid individual in generation 1: 8 x acquisition error"));
}

TEST_F(ExitCodeTest, FourWhenAValidationHasInvalidPoses) {
  put("config.yaml", briefConfig());
  const ProcessResult result = simgap(validate({"--config", "config.yaml"}));
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("simgap: 3 of 3 poses are invalid: p000: "));
  const Json json = Json::parse(text("out/result.json"));
  EXPECT_TRUE(json.at("mje_deg").at("elbow").is_null());
  EXPECT_EQ(json.at("valid_poses"), 0);
}

}  // namespace
}  // namespace simgap::test
