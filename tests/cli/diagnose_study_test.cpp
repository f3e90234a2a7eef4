// How often `simgap diagnose` is right, over many logs from the distribution of tests/reality/drive_draws.h. Prints the
// confusion matrix that docs/studies/diagnose-logs.md keeps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/diagnosis_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

class SlowDiagnosisStudy : public testing::Test {
 protected:
  LogAnswer ask(const reality::DriveDraw& draw) {
    const LogAnswer answer = diagnoseDraw(draw, folder_.path(), SIMGAP_BINARY);
    std::string named = answer.verdict();
    for (const NamedCause& c : answer.causes()) named += " " + c.effect + (c.ambiguous_with.empty() ? "" : "~");
    fmt::print("{:<28} seed {:>6} gain {:4.1f} % -> {}\n", fmt::format("{}", draw.effects[0]), draw.rig.seed,
               100.0 * answer.true_gain, named);
    return answer;
  }
  TemporaryFolder folder_;
};

TEST_F(SlowDiagnosisStudy, IsSilentOnLogsWithNothingHidden) {
  constexpr int kLogs = 100;
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= kLogs; ++seed) alarms += ask(reality::drawNone(seed)).silent() ? 0 : 1;
  fmt::print("false alarms: {} of {}, upper 95 % limit {:.1f} %\n", alarms, kLogs, 100.0 * upperLimit(alarms, kLogs));
  EXPECT_LE(alarms, 5);
  EXPECT_LE(upperLimit(alarms, kLogs), 0.1051);  // 5 of 100 is the most that the rate allows
}

TEST_F(SlowDiagnosisStudy, NamesWhatIsHidden) {
  constexpr int kEach = 5;
  int counted = 0, alone = 0, grouped = 0, fresh_inside = 0, fresh_counted = 0, held = 0, intervals = 0;
  std::map<std::string, std::map<std::string, int>> confusion;
  const std::vector<std::string> effects = reality::drawableEffects();
  for (std::uint64_t k = 0; k < kEach; ++k) {
    for (std::size_t e = 0; e < effects.size(); ++e) {
      const std::string& effect = effects[e];
      const LogAnswer answer = ask(reality::drawEffect(effect, 1000 + 100 * k + e + (k > 0 ? 1 : 0)));
      const auto causes = answer.causes();
      ++confusion[effect][causes.empty() ? answer.verdict() : causes.size() > 1 ? "several" : causes[0].effect];
      if (answer.true_gain < 0.05) continue;
      ++counted;
      alone += answer.namedAlone(effect) ? 1 : 0;
      grouped += answer.namedInGroup(effect) ? 1 : 0;
      if (!answer.namedAlone(effect)) continue;
      if (const auto holds = intervalHoldsTruth(answer)) {
        ++intervals;
        held += *holds ? 1 : 0;
        if (!*holds) fmt::print("  interval misses: {}\n", answer.result.at("causes")[0].at("parameters").dump());
      }
      if (effect == "regime-change") continue;  // a moment does not come again
      const Json cause = answer.result.at("causes")[0];
      const double fresh = 100.0 * gainOnFreshLog(answer.draw, folder_.path(), SIMGAP_BINARY);
      ++fresh_counted;
      const double low = cause.at("gain_ci95")[0], high = cause.at("gain_ci95")[1];
      fresh_inside += low <= fresh && fresh <= high;
      if (fresh < low || fresh > high) {
        fmt::print("  gain on a fresh log {:.1f} %, stated {:.1f} to {:.1f} %\n", fresh, low, high);
      }
    }
  }
  for (const auto& [effect, answers] : confusion) {
    std::string row;
    for (const auto& [answer, count] : answers) row += fmt::format(" {} {}", answer, count);
    fmt::print("{:<26}:{}\n", effect, row);
  }
  fmt::print("gain of 5 % and more: {} logs, named alone {} ({:.0f} %), alone or in a group {} ({:.0f} %)\n", counted,
             alone, 100.0 * alone / counted, grouped, 100.0 * grouped / counted);
  fmt::print("gain on a fresh log within the stated interval: {} of {}\n", fresh_inside, fresh_counted);
  fmt::print("parameter within its 95 % interval: {} of {}\n", held, intervals);
  EXPECT_GE(alone, 0.90 * counted);
  EXPECT_GE(grouped, 0.97 * counted);
  EXPECT_GE(fresh_inside, 0.90 * fresh_counted);
  EXPECT_GE(held, 0.85 * intervals);
}

TEST_F(SlowDiagnosisStudy, NamesTwoAtOnce) {
  constexpr int kLogs = 20;
  int both = 0;
  for (std::uint64_t seed = 1; seed <= kLogs; ++seed) {
    const LogAnswer answer = ask(reality::drawPair(seed));
    both += answer.names(answer.draw.effects[0]) && answer.names(answer.draw.effects[1]) ? 1 : 0;
  }
  fmt::print("both of two named: {} of {}\n", both, kLogs);
  EXPECT_GE(both, 0.8 * kLogs);
}

TEST_F(SlowDiagnosisStudy, DoesNotNameWhatHasNoName) {
  int logs = 0, wrong = 0, right = 0;
  for (const std::string& kind : reality::outsideKinds()) {
    for (std::uint64_t k = 0; k < 5; ++k, ++logs) {
      const LogAnswer answer = ask(reality::drawOutside(kind, 7000 + 10 * static_cast<std::uint64_t>(logs) + k));
      wrong += answer.verdict() == "cause-found" ? 1 : 0;
      bool channel = false;
      for (const Json& left : answer.result.at("left_over").at("channels"))
        channel = channel || left.at("channel") == answer.draw.channel;
      right += answer.verdict() == "unexplained" && channel ? 1 : 0;
    }
  }
  fmt::print("outside the catalogue: {} logs, wrongly named {}, unexplained with the right channel {}\n", logs, wrong,
             right);
  EXPECT_LE(wrong, 0.05 * logs);
  EXPECT_GE(right, 0.8 * logs);
}

}  // namespace
}  // namespace simgap::test
