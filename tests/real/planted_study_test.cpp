// Known effects planted into measured logs: does `simgap diagnose` name them beside what it finds without them, and
// nothing else? And drivers that cannot be right (channels with random phases): does it leave them alone?
//   SIMGAP_REAL_LOGS=emps,ur10e-1      only these logs (asserts nothing: the targets are of all of them)
//   SIMGAP_REAL_EFFECTS=channel-delay  only these effects (the same)
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>

#include "real/planting.h"
#include "support/files.h"

namespace simgap::test {
namespace {

#define SKIP_WITHOUT_LOGS() \
  if (!realFolder()) GTEST_SKIP() << "no measured logs: set SIMGAP_REAL_DATA to their folder"

bool isIn(const char* list, const std::string& name) {
  const char* only = std::getenv(list);
  return only == nullptr || ("," + std::string(only) + ",").find("," + name + ",") != std::string::npos;
}
bool wanted(const std::string& log) { return isIn("SIMGAP_REAL_LOGS", log); }
bool all() { return std::getenv("SIMGAP_REAL_LOGS") == nullptr && std::getenv("SIMGAP_REAL_EFFECTS") == nullptr; }

std::set<std::string> namesOf(const RealAnswer& answer) {
  std::set<std::string> names;
  for (const auto& group : answer.named) names.insert(group[0]);
  return names;
}

double baselineError(const RealAnswer& answer) { return answer.result.at("baseline").at("mse_heldout"); }

/// What is said of a cause that is not named.
std::string candidacy(const RealAnswer& answer, const std::string& effect) {
  if (!answer.error.empty()) return "";
  for (const Json& candidate : answer.result.at("candidates")) {
    if (candidate.at("effect") == effect) return " [candidate: " + candidate.at("reason").get<std::string>() + "]";
  }
  return "";
}

std::string statedBy(const RealAnswer& answer, const std::string& effect, const Planted& planted) {
  const Json* cause = answer.cause(effect);
  return cause == nullptr || !planted.stated ? ""
                                             : fmt::format(" planted {} {:.4g} of {}", planted.stated->first,
                                                           planted.stated->second, cause->at("parameters").dump());
}

enum class Interval { kNone, kHolds, kMisses };

/// Whether the 95 % interval of the stated parameter holds its value (an effort's unit is a torque's: k_a is 1 or not
/// in it).
Interval intervalOf(const RealAnswer& answer, const std::string& effect, const Planted& planted) {
  const Json* cause = answer.cause(effect);
  if (cause == nullptr || !planted.stated) return Interval::kNone;
  for (const Json& p : cause->at("parameters")) {
    if (p.at("name") != planted.stated->first) continue;
    const double low = p.at("ci95")[0], high = p.at("ci95")[1];
    const double value = p.at("name") == "mgl" && high < 0.0 ? -planted.stated->second : planted.stated->second;
    return low <= value && value <= high ? Interval::kHolds : Interval::kMisses;
  }
  return Interval::kNone;
}

TEST(PlantedEffects, JoinWhatIsFoundWithoutThem) {
  SKIP_WITHOUT_LOGS();
  const TemporaryFolder folder;
  int cases = 0, named = 0, changed = 0, held = 0, intervals = 0;
  for (const PlantingPlan& plan : plantingPlans()) {
    if (!wanted(plan.log)) continue;
    const RealLog& real = realLog(plan.log);
    const LogTable table = LogTable::load(*realFolder() / real.file, plan.every);
    table.save(folder.path() / "log.csv");
    const RealAnswer without = diagnoseReal(real, "log.csv", folder.path(), SIMGAP_BINARY);
    fmt::print("{:<14} as it is: {}\n", plan.log, without.text());
    ASSERT_TRUE(without.error.empty());
    std::uint64_t seed = 0;
    for (const std::string& effect : plan.effects) {
      ++seed;
      if (without.names(effect) || !isIn("SIMGAP_REAL_EFFECTS", effect)) continue;
      std::mt19937_64 random(seed + 100 * plan.log.size());
      const double gain = 0.15 * std::pow(4.0, std::uniform_real_distribution<>()(random));
      const Planted planted = plant(plan, table, effect, baselineError(without), gain, seed);
      planted.table.save(folder.path() / "log.csv");
      const RealAnswer answer = diagnoseReal(real, "log.csv", folder.path(), SIMGAP_BINARY);
      const double worth = answer.error.empty() ? 1.0 - baselineError(without) / baselineError(answer) : 0.0;
      const Interval interval = intervalOf(answer, effect, planted);
      std::set<std::string> before = namesOf(without), after = namesOf(answer);
      for (const auto& group : answer.named) {
        if (std::ranges::find(group, effect) != group.end()) after.erase(group[0]);
      }
      fmt::print("{:<14} + {:<22} ({}, {:.3g}) worth {:4.1f} % -> {}{}{}\n", plan.log, effect, planted.shape,
                 planted.magnitude, 100.0 * worth, answer.text() + candidacy(answer, effect),
                 before != after ? " [others change]" : "",
                 interval == Interval::kMisses ? " [interval misses:" + statedBy(answer, effect, planted) + "]" : "");
      std::fflush(stdout);
      if (worth < 0.10) continue;
      ++cases;
      named += answer.names(effect) ? 1 : 0;
      changed += before != after ? 1 : 0;
      intervals += interval != Interval::kNone ? 1 : 0;
      held += interval == Interval::kHolds ? 1 : 0;
    }
  }
  fmt::print(
      "planted, worth 10 % and more: {}; named {}; magnitude within its interval {} of {}; other names change {}\n",
      cases, named, held, intervals, changed);
  if (!all()) GTEST_SKIP() << "a part of the logs";
  EXPECT_GE(named, 0.85 * cases);
  EXPECT_GE(held, 0.85 * intervals);
  EXPECT_LE(changed, 0.05 * cases);
}

/// Whether the answer says that something depends on the channel `effects` are driven by.
bool believes(const RealAnswer& answer, const RealAnswer& without, const std::vector<std::string>& effects,
              const std::string& channel) {
  for (const std::string& effect : effects) {
    if (answer.names(effect) && !without.names(effect)) return true;
  }
  for (const Json& left : answer.result.at("left_over").at("channels")) {
    if (left.at("channel") == channel) return true;
  }
  return false;
}

/// The two channels of a log whose colour a placebo takes: the first that change and are neither time nor session.
std::vector<std::string> coloursOf(const LogTable& table) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < table.header.size() && names.size() < 2; ++k) {
    const std::string& name = table.header[k];
    const std::vector<double>& values = table.columns[k];
    const auto [low, high] = std::ranges::minmax(values);
    const bool finite = std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
    if (name == "time_s" || name == "session" || name == "run" || name == "test" || !finite || low == high) continue;
    names.push_back(name);
  }
  return names;
}

TEST(PlaceboDrivers, AreNotNamed) {
  SKIP_WITHOUT_LOGS();
  const TemporaryFolder folder;
  int cases = 0, believed = 0;
  std::uint64_t seed = 7;
  for (const RealLog& real : realLogs()) {
    if (!wanted(real.name)) continue;
    LogTable table = LogTable::load(*realFolder() / real.file, 1);
    table.save(folder.path() / "log.csv");
    const RealAnswer without = diagnoseReal(real, "log.csv", folder.path(), SIMGAP_BINARY);
    if (!without.error.empty()) continue;  // a log that is refused has nothing to believe in
    // A temperature, and a channel without a meaning, each with the colour of a measured one.
    const std::vector<std::string> colours = coloursOf(table), channels = {"temperature_degC", "humidity_percent"};
    for (std::size_t k = 0; k < colours.size(); ++k) {
      LogTable offered = table;
      const std::string stem = channels[k].substr(0, channels[k].find('_') + 1);
      for (std::size_t c = offered.header.size(); c-- > 0;) {  // instead of the log's own, in whatever unit
        if (!offered.header[c].starts_with(stem)) continue;
        offered.columns.erase(offered.columns.begin() + static_cast<std::ptrdiff_t>(c));
        offered.header.erase(offered.header.begin() + static_cast<std::ptrdiff_t>(c));
      }
      std::vector<double> driver = phasesRandomised(table.column(colours[k]), ++seed);
      const auto [low, high] = std::ranges::minmax(driver);
      for (double& value : driver) value = 25.0 + 20.0 * (value - low) / (high - low);
      offered.header.push_back(channels[k]);
      offered.columns.push_back(driver);
      offered.save(folder.path() / "log.csv");
      const RealAnswer answer = diagnoseReal(real, "log.csv", folder.path(), SIMGAP_BINARY);
      ASSERT_TRUE(answer.error.empty()) << answer.error;
      const bool wrong = believes(answer, without, {"friction-heating", "torque-constant-heating"}, channels[k]);
      fmt::print("{:<14} {} coloured like {}: {}{}\n", real.name, channels[k], colours[k], answer.text(),
                 wrong ? " [BELIEVED]" : "");
      std::fflush(stdout);
      ++cases;
      believed += wrong ? 1 : 0;
    }
  }
  fmt::print("placebo drivers: {}; believed {}\n", cases, believed);
  if (!all()) GTEST_SKIP() << "a part of the logs";
  EXPECT_LE(believed, 0.05 * cases);
}

}  // namespace
}  // namespace simgap::test
