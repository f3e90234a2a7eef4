#include "diagnose/verdict.h"

#include <gtest/gtest.h>

#include <cmath>

namespace simgap::test {
namespace {

Cause named(const std::string& effect, std::vector<std::string> look_alikes = {}) {
  Cause cause;
  cause.effect = effect;
  cause.ambiguous_with = std::move(look_alikes);
  return cause;
}

TEST(Verdict, FollowsFromTheCauses) {
  EXPECT_EQ(verdictOf({}, false), DiagnosisVerdict::kNothingFound);
  EXPECT_EQ(verdictOf({}, true), DiagnosisVerdict::kUnexplained);
  EXPECT_EQ(verdictOf({named("inertia")}, false), DiagnosisVerdict::kCauseFound);
  EXPECT_EQ(verdictOf({named("inertia")}, true), DiagnosisVerdict::kCauseFound);
  EXPECT_EQ(verdictOf({named("inertia"), named("stribeck", {"static-offset"})}, false), DiagnosisVerdict::kAmbiguous);
}

TEST(Verdict, FourLookAlikesAreNoAnswer) {
  EXPECT_EQ(verdictOf({named("a", {"b", "c"})}, false), DiagnosisVerdict::kAmbiguous);
  EXPECT_EQ(verdictOf({named("a", {"b", "c", "d"})}, false), DiagnosisVerdict::kUnexplained);
}

TEST(Verdict, OnlyFaultsThatWereNotPutRightAreOpen) {
  DataFault mended, open;
  mended.corrected = true;
  open.channel = "motor_velocity";
  EXPECT_EQ(openFault({mended, mended}), nullptr);
  const std::vector<DataFault> faults = {mended, open};
  ASSERT_NE(openFault(faults), nullptr);
  EXPECT_EQ(openFault(faults)->channel, "motor_velocity");
}

TEST(Verdict, AbsorptionListsClearShiftsTheLargestFirst) {
  const std::vector<Absorption> list =
      absorbed({{"k_v", 1.9}, {"n_c", 2.1}, {"n_s", -7.0}, {"L", std::nan("")}, {"v_s", -1.0}});
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].parameter, "n_s");
  EXPECT_EQ(list[1].parameter, "n_c");
  EXPECT_EQ(absorbed(std::vector<Absorption>(9, {"k_v", 3.0})).size(), 5u);
}

}  // namespace
}  // namespace simgap::test
