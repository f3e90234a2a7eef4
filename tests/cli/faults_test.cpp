// What a run leaves when the disk fails it: every call that writes fails once in turn, and from each one on.
#include "cli/cli_fixture.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;

class FaultsTest : public CliTest {
 protected:
  /// Runs in which the writing call `at` into `out` fails. The folder of the run is made anew.
  ProcessResult runFailing(const Arguments& arguments, long at, const std::string& on) const {
    fs::remove_all(path("out"));
    Arguments all{"/usr/bin/env",        std::string("LD_PRELOAD=") + SIMGAP_FAIL_WRITES,
                  "FAIL_UNDER=" + out(), "FAIL_AT=" + std::to_string(at),
                  "FAIL_ON=" + on,       "FAIL_COUNT=" + path("count").string()};
    for (const std::string& word : command(arguments)) all.push_back(word);
    return runProcess(all, folder_.path());
  }
  /// Of the run, as the system knows it: the shim compares names.
  std::string out() const { return (fs::canonical(folder_.path()) / "out").string(); }
  long calls() const { return std::stol(text("count")); }

  /// What must be the same in every complete run.
  std::map<std::string, std::string> results() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(path("out"))) {
      const std::string name = entry.path().filename();
      if (name != "run.json" && name != "report.html" && name != "log.txt") files[name] = readText(entry.path());
    }
    return files;
  }
  std::string status() const {
    if (!fs::exists(path("out/run.json"))) return "no run.json";
    return Json::parse(text("out/run.json")).at("status");
  }

  void expectCompleteOrSaysNot(const Arguments& arguments, const std::string& on) const {
    ASSERT_EQ(runFailing(arguments, 0, on).exit_code, 0);
    ASSERT_EQ(status(), "done");
    const auto complete = results();
    const long count = calls();
    ASSERT_GT(count, 20) << "the shim saw no writes";
    long failed = 0;
    for (long at = 1; at <= count; ++at) {
      SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(count) + " fails " + on);
      const ProcessResult result = runFailing(arguments, at, on);
      EXPECT_EQ(result.signal, 0) << result.err;
      if (result.exit_code == 0) {
        EXPECT_EQ(status(), "done");
        EXPECT_EQ(results(), complete);
        EXPECT_TRUE(fs::exists(path("out/report.html")));
        continue;
      }
      ++failed;
      EXPECT_EQ(result.exit_code, 2) << result.err;
      EXPECT_THAT(result.err, testing::HasSubstr("No space left on device"));
      EXPECT_NE(status(), "done");
    }
    EXPECT_GT(failed, count / 2) << "most failures are noticed";
  }
};

TEST_F(FaultsTest, ARunIsCompleteOrSaysItIsNotWhenOneWriteFails) {
  expectCompleteOrSaysNot({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", out()}, "once");
}

TEST_F(FaultsTest, ARunIsCompleteOrSaysItIsNotOnADiskThatIsFullFromThereOn) {
  expectCompleteOrSaysNot({"validate", "arm.yaml", "--poses", "poses.csv", "-q", "-o", out()}, "forever");
}

TEST_F(FaultsTest, AResumedRunAfterAFailureEndsAsIfThereHadBeenNone) {
  const Arguments arguments = calibrate(out());
  ASSERT_EQ(runFailing(arguments, 0, "once").exit_code, 0);
  const std::string undisturbed = found("out");
  const long count = calls();
  long resumed = 0;
  for (long at = count / 3; at <= count; at += count / 6) {
    SCOPED_TRACE("call " + std::to_string(at) + " of " + std::to_string(count));
    if (runFailing(arguments, at, "forever").exit_code == 0 || !fs::exists(path("out/inputs/inputs.json"))) continue;
    ++resumed;
    succeed({"calibrate", "--resume", "out", "-q"});
    EXPECT_EQ(status(), "done");
    EXPECT_EQ(found("out"), undisturbed);
  }
  EXPECT_GT(resumed, 0);
}

}  // namespace
}  // namespace simgap::test
