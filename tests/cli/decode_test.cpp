// EEG decoded as a user does it.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

std::string eegFile(const std::string& name) { return sourceFile("data/eeg/" + name).string(); }

class DecodeTest : public CliTest {
 protected:
  DecodeTest() { succeed({"decode", "train", eegFile("imagery.csv.gz"), "-q", "-o", "decoder"}); }

  /// How often the state changes.
  int switches(const Arguments& more) const {
    Arguments all{"decode", "run", "decoder/decoder.yaml", eegFile("imagery-later.csv.gz"), "-q", "--force", "-o", "d"};
    all.insert(all.end(), more.begin(), more.end());
    succeed(all);
    return Json::parse(text("d/result.json")).at("switches");
  }
};

TEST_F(DecodeTest, ARunTakesAnotherThreshold) {
  EXPECT_EQ(switches({"--threshold", "0.7"}), switches({}));  // the decoder's own
  EXPECT_GT(switches({"--threshold", "0.5"}), switches({"--threshold", "0.95"}));
}

TEST_F(DecodeTest, ARunRefusesWhatOnlyTrainingTakes) {
  for (const auto& [option, value] :
       std::map<std::string, std::string>{{"--low", "8"}, {"--high", "20"}, {"--window-s", "2"}, {"--folds", "3"}}) {
    expectRefused({"decode", "run", "decoder/decoder.yaml", eegFile("imagery-later.csv.gz"), option, value, "-o", "d"},
                  2, "found " + option + " with decode run, expected it with train");
  }
}

}  // namespace
}  // namespace simgap::test
