// What `simgap diagnose` says of measured logs whose physics is known: each known answer is a test of its own, and no
// log may get a name that its rig is known not to have. Prints the table of docs/studies/real-logs.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "real/planting.h"
#include "simgap/core/csv.h"
#include "support/files.h"

namespace simgap::test {
namespace {

#define SKIP_WITHOUT_LOGS() \
  if (!realFolder()) GTEST_SKIP() << "no measured logs: set SIMGAP_REAL_DATA to their folder"

class RealLogs : public testing::Test {
 protected:
  RealAnswer ask(const std::string& name) {
    const RealLog& real = realLog(name);
    RealAnswer answer = diagnoseReal(real, *realFolder() / real.file, folder_.path(), SIMGAP_BINARY);
    fmt::print("{:<24} {}\n", name, answer.text());
    return answer;
  }
  /// |measured - extended model| / |measured| of the rows that count.
  double relativeError() const {
    const CsvTable table = CsvTable::load(folder_.path() / "d/predictions.csv");
    const auto measured = table.quantity("measured", ""), predicted = table.quantity("after", "");
    const auto used = table.quantity("used", "");
    double error = 0.0, size = 0.0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      if (used[i] == 0.0) continue;
      error += std::pow(measured[i] - predicted[i], 2), size += measured[i] * measured[i];
    }
    return std::sqrt(error / size);
  }
  static double value(const Json& cause, const std::string& name) {
    for (const Json& p : cause.at("parameters")) {
      if (p.at("name") == name) return p.at("value");
    }
    return NAN;
  }
  TemporaryFolder folder_;
};

void expectOnly(const RealAnswer& answer, const std::string& effect) {
  ASSERT_EQ(answer.named.size(), 1u) << answer.text();
  EXPECT_EQ(answer.named[0], std::vector<std::string>{effect}) << answer.text();
}

TEST_F(RealLogs, EmpsHasViscousFrictionThatDiffersByDirection) {
  SKIP_WITHOUT_LOGS();
  const RealAnswer answer = ask("emps");
  expectOnly(answer, "viscous-asymmetry");
  EXPECT_NEAR(relativeError(), 0.0311, 0.002);  // of friction by direction; symmetric friction and an offset: 0.0408
}

TEST_F(RealLogs, JointFourOfTheUr10eHasAWeightAndNothingElse) {
  SKIP_WITHOUT_LOGS();
  const RealAnswer answer = ask("ur10e-4");
  expectOnly(answer, "joint-gravity");
  const Json* gravity = answer.cause("joint-gravity");
  ASSERT_NE(gravity, nullptr);
  EXPECT_GE(gravity->at("gain_heldout_percent").get<double>(), 90.0);
  // Least squares with friction, inertia and a constant, over the moving rows: 0.328 A of gravity.
  EXPECT_NEAR(std::abs(value(*gravity, "mgl")), 0.33, 0.01);
  EXPECT_LE(std::sqrt(answer.result.at("extended").at("mse_heldout").get<double>()), 0.045);
}

TEST_F(RealLogs, TheCommandedVoltageOfTheServoIsLateAndMeetsASpeedLimit) {
  SKIP_WITHOUT_LOGS();
  const RealAnswer answer = ask("sts3215-1168-commanded");
  const Json *delay = answer.cause("channel-delay"), *limit = answer.cause("speed-limit");
  ASSERT_NE(delay, nullptr) << answer.text();
  EXPECT_GE(std::abs(value(*delay, "dt")), 0.040);
  EXPECT_LE(std::abs(value(*delay, "dt")), 0.051);
  ASSERT_NE(limit, nullptr) << answer.text();
  EXPECT_NEAR(value(*limit, "w_limit"), 4.3, 0.2);
}

TEST_F(RealLogs, TheDamperHasDeadTravel) {
  SKIP_WITHOUT_LOGS();
  const RealAnswer answer = ask("damper");
  expectOnly(answer, "backlash");
  const Json* backlash = answer.cause("backlash");
  ASSERT_NE(backlash, nullptr);
  EXPECT_GE(value(*backlash, "play"), 0.004);
  EXPECT_LE(value(*backlash, "play"), 0.006);
}

TEST_F(RealLogs, LockedSpringsHaveNoCauseOfMotion) {
  SKIP_WITHOUT_LOGS();
  for (const std::string name : {"sea-spring5_ramp6", "sea-spring1_ramp1", "sea-spring2_ramp2"}) {
    EXPECT_TRUE(ask(name).named.empty()) << name;
  }
}

/// Six ramps of growing amplitude on one spring, each a session. That its sides differ needs no model: the middle of a
/// ramp's ends in torque stays where it is, the middle of their deflections goes from 0.05 to 0.7 mrad with the
/// amplitude, which neither an offset does, nor a spring that is the same on both sides.
TEST_F(RealLogs, TheSpringSoftensWithHysteresisAndItsSidesDiffer) {
  SKIP_WITHOUT_LOGS();
  const std::string torque = "measured_torque_Nm", deflection = "spring_deflection_rad";
  LogTable pooled;
  std::vector<double> middles;
  for (int ramp = 1; ramp <= 6; ++ramp) {
    LogTable one = LogTable::load(*realFolder() / fmt::format("sea_rmd_x8_spring/spring5_ramp{}.csv.gz", ramp), 1);
    const auto middle = [&](const std::string& name) {
      const auto [low, high] = std::ranges::minmax(one.column(name));
      return (low + high) / 2.0;
    };
    middles.push_back(middle(deflection));
    EXPECT_LT(std::abs(middle(torque)), 0.15) << ramp;
    one.header.emplace_back("session");
    one.columns.emplace_back(one.columns[0].size(), ramp);
    pooled.append(one);
  }
  EXPECT_LT(middles.front(), 0.1e-3);
  EXPECT_GT(middles.back(), 0.6e-3);
  pooled.save(folder_.path() / "ramps.csv");
  const RealLog log{
      "spring5", "spring", {}, {}, {"--map", "deflection_rad=" + deflection, "--map", "torque_Nm=" + torque},
      {},        {},       {}};
  const RealAnswer answer = diagnoseReal(log, "ramps.csv", folder_.path(), SIMGAP_BINARY);
  fmt::print("{:<24} {}\n", log.name, answer.text());
  EXPECT_TRUE(answer.names("spring-hysteresis")) << answer.text();
  for (const auto& group : answer.named) {
    EXPECT_TRUE(group[0] == "spring-hysteresis" || group[0] == "spring-softening" || group[0] == "spring-direction")
        << answer.text();
  }
}

/// Every log: right, in a group, silent or honest, or a wrong name.
TEST_F(RealLogs, GetNoWrongName) {
  SKIP_WITHOUT_LOGS();
  int right = 0, missed = 0, refused = 0;
  std::vector<std::string> wrong;
  for (const RealLog& real : realLogs()) {
    const RealAnswer answer = ask(real.name);
    refused += answer.error.empty() ? 0 : 1;
    const auto known = [&](const std::string& effect) {
      return std::ranges::find(real.truth, effect) != real.truth.end() ||
             std::ranges::find(real.allowed, effect) != real.allowed.end();
    };
    bool mistaken = false;
    for (const auto& group : answer.named) mistaken = mistaken || std::ranges::none_of(group, known);
    const bool found = std::ranges::all_of(real.truth, [&](const auto& effect) { return answer.names(effect); });
    if (mistaken) wrong.push_back(real.name + ": " + answer.text() + " (" + real.reason + ")");
    right += !mistaken && found ? 1 : 0;
    missed += !mistaken && !found ? 1 : 0;
  }
  fmt::print(
      "measured logs: {}; nothing wrong and all that is known found {}, something known missed {}, wrong name {}, "
      "refused {}\n",
      realLogs().size(), right, missed, wrong.size(), refused);
  for (const std::string& line : wrong) ADD_FAILURE() << "wrong name: " << line;
}

/// Another simulator's unkind logs; the causes in them have other shapes than the catalogue's formulas.
/// First: the log; second: the cause, empty where nothing is hidden.
class StandstillLogs : public testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(StandstillLogs, AreNamedRight) {
  const auto folder = standstillFolder();
  if (!folder) GTEST_SKIP() << "no standstill logs beside the measured ones";
  const TemporaryFolder out;
  const RealLog log{"standstill", "classic", {}, {}, {"--ratio", "97.74"}, {}, {}, {}};
  const auto file = *folder / ("standstill-" + GetParam().first + ".csv.gz");
  const RealAnswer answer = diagnoseReal(log, file, out.path(), SIMGAP_BINARY);
  fmt::print("{:<24} {}\n", GetParam().first, answer.text());
  if (GetParam().second.empty()) {
    EXPECT_EQ(answer.verdict(), "nothing-found") << answer.text();
  } else {
    expectOnly(answer, GetParam().second);
  }
}

INSTANTIATE_TEST_SUITE_P(Real, StandstillLogs,
                         testing::Values(std::pair<std::string, std::string>{"none-31", ""},
                                         std::pair<std::string, std::string>{"none-32", ""},
                                         std::pair<std::string, std::string>{"bend-linear-33", "bend-friction"},
                                         std::pair<std::string, std::string>{"heating-34", "friction-heating"},
                                         std::pair<std::string, std::string>{"knee-35", "torque-saturation"}),
                         [](const auto& instance) {
                           std::string name = instance.param.first;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace simgap::test
