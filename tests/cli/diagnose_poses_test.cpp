// diagnose --poses as a user runs it.
#include <regex>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

class DiagnosePoses : public CliTest {
 protected:
  DiagnosePoses() { put("poses.csv", firstLines(readText(sourceFile("data/arm-dense/poses_calibration.csv")), 33)); }
  Arguments diagnose(const Arguments& more = {}) const {
    Arguments all{"diagnose", "arm.yaml", "--poses", "poses.csv", "--effects", "payload,muscle-wrap", "-q", "-o", "d"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(DiagnosePoses, WritesAResultAndAModelThatValidates) {
  succeed(diagnose());
  const Json result = Json::parse(text("d/result.json"));
  EXPECT_EQ(result.at("format"), "simgap/diagnose/1");
  EXPECT_TRUE(result.contains("verdict"));
  EXPECT_GT(result.at("baseline").at("noise_floor").get<double>(), 0.0);
  // A payload of either moving body; a wrap has no slope where it begins, and so no smallest size.
  EXPECT_EQ(result.at("detectable").size(), 2u);
  EXPECT_FALSE(result.at("next_experiment").get<std::string>().empty());
  succeed({"validate", "d/model.yaml", "--poses", "poses.csv", "--evaluator", "equilibrium", "-q", "-o", "v"});
}

TEST_F(DiagnosePoses, OldAndNewPosesTogetherAreTheSameAsOneFile) {
  const std::string all = text("poses.csv"), header = firstLines(all, 1);
  const std::string old_ones = firstLines(all, 21);
  put("old.csv", old_ones);
  put("new.csv", header + all.substr(old_ones.size()));
  const Arguments rest = {"--effects", "payload", "-q"};
  const auto diagnosed = [&](Arguments command, const std::string& directory) {
    command.insert(command.end(), rest.begin(), rest.end());
    command.insert(command.end(), {"-o", directory});
    succeed(command);
    return text(directory + "/hypotheses.csv");
  };
  EXPECT_EQ(diagnosed({"diagnose", "arm.yaml", "--poses", "old.csv", "--poses", "new.csv"}, "two"),
            diagnosed({"diagnose", "arm.yaml", "--poses", "poses.csv"}, "one"));
  EXPECT_EQ(text("two/candidates/poses.csv"), text("old.csv"));
  EXPECT_EQ(text("two/candidates/poses_2.csv"), text("new.csv"));
  put("change.yaml",
      "format: simgap/change/1\nchanges:\n  - {kind: mass, body: forearm, at_m: [0, 0, -0.1], mass_kg: 0.5}\n");
  succeed({"intervene", "two", "--change", "change.yaml", "-q", "-o", "foreseen"});
  expectRefused({"diagnose", "arm.yaml", "--poses", "old.csv", "--poses", "old.csv", "-o", "d"}, 3,
                "expected names of its own");
  put("copy.csv", std::regex_replace(text("old.csv"), std::regex("\np"), "\nq"));
  expectRefused({"diagnose", "arm.yaml", "--poses", "old.csv", "--poses", "copy.csv", "-o", "d"}, 3,
                "the same readings twice are no more evidence");
}

TEST_F(DiagnosePoses, RefusesWhatItCannotUse) {
  expectRefused(diagnose({"--log", "poses.csv"}), 2, "expected one of them");
  expectRefused({"diagnose", "arm.yaml", "-o", "d"}, 2, "expected one of them");
  expectRefused(diagnose({"--holdout", "session=3"}), 2, "expected a fraction of the poses");
  expectRefused({"diagnose", "arm.yaml", "--poses", "poses.csv", "--effects", "magic", "-o", "d"}, 2, "found 'magic'");
}

TEST_F(DiagnosePoses, ModelsWithExtensionsAreTakenByEveryCommand) {
  put("extended.yaml",
      text("arm.yaml") +
          "extensions:\n  - {effect: payload, target: forearm, parameters: {mass: {value: 0.3, unit: kg}, "
          "distance: {value: 0.2, unit: m}}}\n");
  for (const std::string evaluator : {"bullet", "equilibrium"}) {
    succeed({"validate", "extended.yaml", "--poses", "poses.csv", "--evaluator", evaluator, "-q", "-o", evaluator});
  }
  succeed({"validate", "arm.yaml", "--poses", "poses.csv", "--evaluator", "equilibrium", "-q", "-o", "plain"});
  const auto error = [&](const std::string& directory) {
    return Json::parse(text(directory + "/result.json")).at("mje_deg").at("elbow").get<double>();
  };
  EXPECT_NEAR(error("bullet"), error("equilibrium"), 1.0) << "joint friction lets the first stop beside the second";
  EXPECT_GT(std::abs(error("plain") - error("equilibrium")), 0.2);
  put("creep.yaml", text("arm.yaml") +
                        "extensions:\n  - {effect: cord-creep, parameters: {rate: {value: 1.0e-6, unit: m_s}, "
                        "time_constant: {value: 900, unit: s}}}\n");
  put("timeless.csv", replaced(text("poses.csv"), "time_s", "clock"));
  expectRefused({"validate", "creep.yaml", "--poses", "timeless.csv", "-o", "t"}, 3, "found no column time_s");
}

}  // namespace
}  // namespace simgap::test
