// Runs held against each other and against a budget, as a user types it.
#include "cli/cli_fixture.h"
#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

class CompareTest : public CliTest {
 protected:
  /// A spring's log whose force is `factor` times a line with noise of a fixed pattern.
  void recordSpring(const std::string& name, double stiffness, double phase) const {
    CsvWriter csv({"time_s", "deflection_m", "force_N"});
    for (int i = 0; i < 400; ++i) {
      const double t = 0.05 * i, x = 0.02 + 0.01 * std::sin(1.3 * t);
      csv.add(t).add(x).add(stiffness * x + 0.1 * std::sin(97.0 * t + phase) + 0.1 * std::sin(41.0 * t * t)).endRow();
    }
    put(name + ".csv", csv.text());
    succeed({"fit-spring", name + ".csv", "-q", "-o", name});
  }
};

TEST_F(CompareTest, AStifferSpringDiffersAndEqualOnesAgree) {
  recordSpring("a", 300.0, 0.0);
  recordSpring("b", 300.0, 1.0);
  recordSpring("c", 360.0, 2.0);
  EXPECT_THAT(succeed({"compare", "a", "b", "-q", "-o", "same"}), HasSubstr("2 runs agree"));
  EXPECT_THAT(succeed({"compare", "a", "b", "c/", "-q", "-o", "other"}), HasSubstr("stiffness"));
  const Json result = Json::parse(text("other/result.json"));
  EXPECT_EQ(result.at("parameters")[0].at("name"), "stiffness");
  EXPECT_EQ(result.at("parameters")[0].at("verdict"), "differs");
  EXPECT_EQ(result.at("runs")[2].at("name"), "c");
  EXPECT_EQ(CsvTable::load(path("other/parameters.csv")).rows(), 3 * result.at("parameters").size());
}

// A damping that is lost is what differs most: a run that could not find it was left out without a word.
TEST_F(CompareTest, SaysWhatOnlySomeRunsKnow) {
  const auto record = [&](const std::string& name, double damping) {
    CsvWriter csv({"time_s", "deflection_m", "force_N"});
    for (int i = 0; i < 400; ++i) {
      const double t = 0.05 * i, x = 0.02 + 0.01 * std::sin(1.3 * t), rate = 0.013 * std::cos(1.3 * t);
      csv.add(t).add(x).add(300.0 * x + damping * rate + 0.01 * std::sin(97.0 * t)).endRow();
    }
    put(name + ".csv", csv.text());
    succeed({"fit-spring", name + ".csv", "-q", "-o", name});
  };
  record("before", 20.0);
  record("late", -20.0);
  const std::string told = succeed({"compare", "before", "late", "-q", "-o", "k"});
  EXPECT_THAT(told, HasSubstr("1 more cannot be compared"));
  EXPECT_THAT(told, HasSubstr("damping is at a bound or not determined in late"));
  EXPECT_EQ(Json::parse(text("k/result.json")).at("partly_known"), Json({"damping"}));
}

TEST_F(CompareTest, ABrokenBudgetEndsWithOne) {
  recordSpring("a", 300.0, 0.0);
  put("kept.yaml", "format: simgap/budget/1\nlimits:\n  - {parameter: stiffness, lower: 250, upper: 350}\n");
  put("broken.yaml", "format: simgap/budget/1\nlimits:\n  - {parameter: stiffness, upper: 250}\n");
  EXPECT_THAT(succeed({"guard", "kept.yaml", "a", "-q", "-o", "g"}), HasSubstr("1 of 1 limits hold"));
  EXPECT_EQ(simgap({"guard", "broken.yaml", "a", "-q", "-o", "h"}).exit_code, 1);
  EXPECT_THAT(text("h/guard.xml"), HasSubstr("stiffness is at most 250"));
  EXPECT_THAT(text("h/guard.md"), HasSubstr("**broken**"));
}

TEST_F(CompareTest, RefusesWhatCannotBeCompared) {
  recordSpring("a", 300.0, 0.0);
  expectRefused({"compare", "a", "-o", "x"}, 2, "found one run, expected two or more to compare");
  expectRefused({"compare", "a", "a/", "-o", "x"}, 2, "twice, expected every run once");
  expectRefused({"compare", "a", "nowhere", "-o", "x"}, 2, "nowhere: found no run.json");
  put("bad.yaml", "format: simgap/budget/1\nlimits:\n  - {parameter: stiffness}\n");
  expectRefused({"guard", "bad.yaml", "a", "-o", "x"}, 2, "bad.yaml:3: limits[0]: found no limit");
}

}  // namespace
}  // namespace simgap::test
