// intervene as a user runs it: on what diagnose --poses has left.
#include <gmock/gmock.h>

#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

class Intervene : public CliTest {
 protected:
  Intervene() {
    put("poses.csv", firstLines(readText(sourceFile("data/arm-dense/poses_calibration.csv")), 33));
    const std::string all = readText(sourceFile("data/arm-dense/poses_calibration.csv")), head = firstLines(all, 1),
                      seen = firstLines(all, 33), both = firstLines(all, 73);
    put("after.csv", head + both.substr(seen.size()));
    put("weight.yaml", readText(sourceFile("data/arm-dense/weight.yaml")));
    put("off.yaml", "format: simgap/change/1\nchanges: [{kind: undo, cause: 'payload:forearm'}]\n");
    succeed({"diagnose", "arm.yaml", "--poses", "poses.csv", "--effects", "payload,gravity-tilt", "-q", "-o", "d"});
  }
};

TEST_F(Intervene, ForeseesAndJudges) {
  succeed({"intervene", "d", "--change", "weight.yaml", "--change", "off.yaml", "-q", "-o", "foreseen"});
  const Json foreseen = Json::parse(text("foreseen/result.json"));
  EXPECT_EQ(foreseen.at("verdict"), "foreseen");
  EXPECT_EQ(foreseen.at("changes").size(), 2u);
  EXPECT_EQ(foreseen.at("changes").at(0).at("name"), "0.3 kg on the hand");
  EXPECT_EQ(foreseen.at("changes").at(1).at("name"), "off");
  // The weight was not hung on: whatever the diagnosis named, no model predicts these poses.
  succeed({"intervene", "d", "--change", "weight.yaml", "--poses", "after.csv", "-q", "-o", "judged"});
  const Json judged = Json::parse(text("judged/result.json"));
  EXPECT_EQ(judged.at("verdict"), "cannot-tell");
  EXPECT_THAT(judged.at("sentence").get<std::string>(), HasSubstr("none of"));
  EXPECT_EQ(judged.at("poses_given"), 40);
  EXPECT_THAT(text("judged/predictions.csv"), HasSubstr("pose,joint,00 "));
  EXPECT_THAT(text("judged/report.html"), HasSubstr("Errors after the change"));
}

TEST_F(Intervene, ChoosesPosesThatTellAndJudgesThem) {
  expectRefused({"design", "--separate", "d", "--loads", "2", "-o", "x"}, 2, "found --loads with a diagnosis of poses");
  succeed({"design", "--separate", "d", "--count", "3", "--candidates", "40", "-q", "-o", "next"});
  const Json next = Json::parse(text("next/result.json"));
  ASSERT_EQ(next.at("smallest").size(), 3u);
  EXPECT_GE(next.at("smallest").at(2), next.at("smallest_random").at(2));
  EXPECT_THAT(text("next/next_poses.csv"), HasSubstr("next-3,"));
  EXPECT_THAT(text("next/report.html"), HasSubstr("What so many poses are expected to tell"));
  // Commands that pull harder are not drawn.
  const ProcessResult weak = simgap(
      {"design", "--separate", "d", "--count", "3", "--candidates", "40", "--max-tension-N", "0.001", "-o", "weak"});
  EXPECT_EQ(weak.exit_code, 4);
  EXPECT_THAT(weak.err, HasSubstr("with no muscle pulled by more than 0.001 N, expected 3 at least"));
  // Further poses of the same arm need no change to judge.
  succeed({"intervene", "d", "--poses", "after.csv", "-q", "-o", "further"});
  EXPECT_EQ(Json::parse(text("further/result.json")).at("change"), "further poses");
}

TEST_F(Intervene, PosesThatFoundTheCauseDoNotConfirmIt) {
  expectRefused({"intervene", "d", "--poses", "poses.csv", "-o", "x"}, 3, "found 31 of 32 poses with readings");
  put("some.csv", replaced(firstLines(text("poses.csv"), 11), "\np", "\nq"));
  expectRefused({"intervene", "d", "--poses", "some.csv", "-o", "x"}, 3, "do not confirm it");
}

TEST_F(Intervene, RefusesWhatItCannotUse) {
  expectRefused({"intervene", "d", "-o", "x"}, 2, "found neither --change nor --poses");
  expectRefused({"intervene", "d", "--log", "poses.csv", "-o", "x"}, 2, "with a diagnosis of poses, expected --poses");
  expectRefused({"intervene", "data", "--change", "weight.yaml", "-o", "x"}, 2, "found no folder candidates");
  expectRefused({"intervene", "data", "--log", "poses.csv", "-o", "x"}, 2, "where nothing was found there are none");
  expectRefused(
      {"intervene", "d", "--change", "weight.yaml", "--change", "off.yaml", "--poses", "after.csv", "-o", "x"}, 2,
      "found 2 files of --change with --poses, expected the one that was made");
  put("wrong.yaml", "format: simgap/change/1\nchanges: [{kind: mass, body: hand, at_m: [0, 0, 0], mass_kg: 1}]\n");
  expectRefused({"intervene", "d", "--change", "wrong.yaml", "-o", "x"}, 2, "wrong.yaml:2");
  put("wrong.yaml", "format: simgap/change/1\nchanges: []\n");
  expectRefused({"intervene", "d", "--change", "wrong.yaml", "-o", "x"}, 2, "found no change");
  put("d/candidates/candidates.yaml", replaced(text("d/candidates/candidates.yaml"), "used: [", "used: [nobody, "));
  expectRefused({"intervene", "d", "--change", "weight.yaml", "-o", "x"}, 3, "found no pose nobody");
  std::filesystem::remove(path("d/candidates/given.yaml"));
  expectRefused({"intervene", "d", "--change", "weight.yaml", "-o", "x"}, 2, "given.yaml");
}

}  // namespace
}  // namespace simgap::test
