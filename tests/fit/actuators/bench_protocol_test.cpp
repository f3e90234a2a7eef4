// Logs that `design --drive` asks for: what they keep, and what fits to recordings of them reach, by the drive of
// tests/reality, which knows no law of the models.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/actuators/bench_protocol.h"
#include "simgap/fit/actuators/friction_fit.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using reality::FrictionTruth;

FrictionTruth benchTruth() {
  FrictionTruth truth;
  truth.sliding_offset = 0.6;
  truth.breakaway_offset = 0.8;
  truth.noise_memory = 0.6;
  return truth;
}

std::string limitsYaml(double seconds, const std::string& law = "variant-b") {
  return fmt::format(
      "format: simgap/drive-limits/1\nduration_s: {:g}\nsession_s: 20\ntransmission_ratio: 97.74\nlower_deg: "
      "-60\nupper_deg: 60\nvelocity_deg_s: 140\nacceleration_rad_s2: 10\ntorque_Nm: 20\ncurrent_A: 40\nnoise: "
      "{{current_A: 0.25, memory: 0.6}}\nweights: [{{mass_kg: 0, length_m: 0.4}}, {{mass_kg: 1, length_m: 0.4}}, "
      "{{mass_kg: 2.5, length_m: 0.4}}, {{mass_kg: 4.5, length_m: 0.4}}]\nlaw: {}\n",
      seconds, law);
}
const std::string kGuess =
    "guess: {k_a: 1.3, n_c1: 0.25, n_c2: 0.6, n_s1: 0.4, n_s2: 0.8, k_v: 0.012, v_s: 12, delta: 1.2}\n";

DriveLimits driveLimits(const std::string& yaml) {
  return DriveLimits::read(YamlNode::parse(yaml, "limits.yaml"), nullptr);
}

BenchProtocol protocolFor(const std::string& yaml, std::uint64_t seed = 1) {
  return designProtocol(driveLimits(yaml), seed, [](double) {});
}

TEST(BenchProtocol, MotionsBeginAtRestAndTheirRatesAreTheirSlopes) {
  for (const BenchMotion& motion : {BenchMotion{BenchMotion::Kind::kSine, 0.2, 0.5, 1.5, 4.5, 0.0, 0},
                                    BenchMotion{BenchMotion::Kind::kMoves, -0.1, 0.4, 1.2, 6.0, 0.7, 0}}) {
    EXPECT_EQ(motion.at(0.0).velocity, 0.0);
    double lower = INFINITY, upper = -INFINITY, fastest = 0.0;
    constexpr double kStep = 1e-4;
    for (double t = kStep; t < 6.0; t += 0.0171) {
      const BenchMotion::State before = motion.at(t - kStep), now = motion.at(t), after = motion.at(t + kStep);
      EXPECT_NEAR(now.velocity, (after.angle - before.angle) / (2.0 * kStep), motion.acceleration * kStep);
      lower = std::min(lower, now.angle);
      upper = std::max(upper, now.angle);
      fastest = std::max(fastest, std::abs(now.velocity));
    }
    EXPECT_NEAR(lower, motion.middle - motion.amplitude, 2e-3);
    EXPECT_NEAR(upper, motion.middle + motion.amplitude, 2e-3);
    EXPECT_NEAR(fastest, motion.speed, 2e-3);
  }
}

TEST(BenchProtocol, KeepsTheLimitsAndIsExpectedToTellMoreThanSessionsAtRandom) {
  const DriveLimits limits = driveLimits(limitsYaml(120) + kGuess);
  const BenchProtocol found = designProtocol(limits, 1, [](double) {});
  ASSERT_EQ(found.sessions.size(), 6u);
  ASSERT_EQ(found.time.size(), 6000u);
  double step = 0.0;
  for (std::size_t i = 0; i < found.time.size(); ++i) {
    ASSERT_GE(found.angle[i], limits.lower);
    ASSERT_LE(found.angle[i], limits.upper);
    ASSERT_LE(std::abs(found.velocity[i]), limits.velocity * (1.0 + 1e-12));
    ASSERT_LE(std::abs(found.acceleration[i]), limits.acceleration * (1.0 + 1e-12));
    ASSERT_LE(std::abs(found.load[i]), limits.torque);
    ASSERT_LE(std::abs(found.current[i]), limits.current);
    if (i > 0 && found.session[i] == found.session[i - 1]) {
      step = std::max(step, std::abs(found.angle[i] - found.angle[i - 1]) * limits.rate);
    }
    // The load is that of a point mass on a lever.
    const LeverWeight& weight = limits.weights[found.sessions[found.session[i]].weight];
    ASSERT_NEAR(found.load[i],
                weight.mass * weight.length * (9.81 * std::sin(found.angle[i]) + weight.length * found.acceleration[i]),
                1e-9);
  }
  EXPECT_LE(step, limits.velocity);
  for (const ProtocolPrecision& random : found.random) EXPECT_LT(found.precision.log_sd, random.log_sd);
}

TEST(BenchProtocol, LastsNoLongerThanItMay) {
  EXPECT_EQ(protocolFor(limitsYaml(79) + kGuess).sessions.size(), 3u);
  EXPECT_EQ(protocolFor(limitsYaml(80) + kGuess).sessions.size(), 4u);
}

TEST(BenchProtocol, TheSameSeedGivesTheSameSessions) {
  const BenchProtocol one = protocolFor(limitsYaml(60) + kGuess, 7), again = protocolFor(limitsYaml(60) + kGuess, 7),
                      other = protocolFor(limitsYaml(60) + kGuess, 8);
  EXPECT_EQ(one.angle, again.angle);
  EXPECT_EQ(one.current, again.current);
  EXPECT_NE(one.angle, other.angle);
}

/// A recording of the protocol by the drive of tests/reality.
reality::FrictionLog recorded(const BenchProtocol& protocol, const FrictionTruth& truth, std::uint64_t seed) {
  const reality::BenchRun run{
      protocol.angle, protocol.velocity, protocol.load, {protocol.session.begin(), protocol.session.end()}};
  return reality::recordMotion(truth, run, {.seed = seed});
}

/// Standard deviations that fits to `logs` recordings state, and how far from the truth they are, by parameter.
struct Reached {
  std::map<std::string, double> stated, error;
};
template <typename Record>
Reached fitsOf(const Record& record, const FrictionTruth& truth, int logs) {
  const std::map<std::string, double> values = {{"k_a", truth.torque_per_ampere}, {"n_c1", truth.sliding_per_load},
                                                {"n_c2", truth.sliding_offset},   {"n_s1", truth.breakaway_per_load},
                                                {"n_s2", truth.breakaway_offset}, {"k_v", truth.viscous},
                                                {"v_s", truth.stribeck_velocity}, {"delta", truth.stribeck_exponent}};
  Reached reached;
  std::map<std::string, std::vector<double>> stated;
  FrictionFitOptions options;
  options.folds = 0;
  for (int k = 0; k < logs; ++k) {
    const FrictionFit fit = fitFriction(friction::find("variant-b"), frictionData(record(100 + k)), options);
    for (const Estimate& e : fit.uncertainty.estimates) {
      stated[e.name].push_back(e.sd);
      reached.error[e.name] += std::pow(e.value - values.at(e.name), 2) / logs;
    }
  }
  for (auto& [name, sds] : stated) reached.stated[name] = median(sds);
  for (auto& [name, square] : reached.error) square = std::sqrt(square);
  return reached;
}

double meanRatio(const std::map<std::string, double>& of, const std::map<std::string, double>& to) {
  double sum = 0.0;
  for (const auto& [name, value] : of) sum += std::log(value / to.at(name));
  return std::exp(sum / static_cast<double>(of.size()));
}

TEST(BenchProtocol, FitsToARecordingReachWhatWasExpected) {
  const FrictionTruth truth = benchTruth();
  const BenchProtocol protocol = protocolFor(limitsYaml(300) + kGuess);
  const Reached reached = fitsOf([&](int seed) { return recorded(protocol, truth, seed); }, truth, 3);
  for (const Estimate& e : protocol.precision.expected) {
    // A standard deviation from blocks of 20 s is itself known to some 20 %.
    EXPECT_GT(reached.stated.at(e.name), 0.6 * e.sd) << e.name;
    EXPECT_LT(reached.stated.at(e.name), 1.6 * e.sd) << e.name;
  }
}

TEST(BenchProtocol, CausesAreToldWithTheLaw) {
  const BenchProtocol alone = protocolFor(limitsYaml(120) + kGuess);
  const BenchProtocol with =
      protocolFor(limitsYaml(120) + kGuess + "causes: [bend-friction, direction-asymmetry, inertia]\n");
  std::map<std::string, double> sd;
  for (const Estimate& e : with.precision.expected) sd[e.name] = e.sd;
  EXPECT_GT(sd.at("bend-friction.mu"), 0.0);
  EXPECT_LT(sd.at("bend-friction.mu"), 0.2) << "per rad";
  EXPECT_GT(sd.at("direction-asymmetry.a"), 0.0);
  EXPECT_LT(sd.at("direction-asymmetry.a"), 0.2);
  EXPECT_LT(alone.precision.expected.size(), with.precision.expected.size());
}

TEST(BenchProtocol, BadLimitsGetASentence) {
  const auto sentenceOf = [](const std::string& yaml) -> std::string {
    try {
      protocolFor(yaml);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  const auto expect = [&](const std::string& yaml, const std::string& part) {
    const std::string sentence = sentenceOf(yaml);
    EXPECT_NE(sentence.find(part), std::string::npos) << "found: " << sentence << "\nexpected: " << part;
  };
  const std::string good = limitsYaml(60);
  const auto edited = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  expect(good, "guess");
  expect(good + "guess: {k_a: 1.3}\n", "n_c1");
  expect(edited(good, "variant-b", "coulomb-c") + kGuess, "found the friction law 'coulomb-c'");
  expect(edited(good, "upper_deg: 60", "upper_deg: -70") + kGuess, "expected the lower below");
  expect(edited(good, "current_A: 40", "current_A: 0.01") + kGuess, "found no motion");
  expect(edited(good, "duration_s: 60", "duration_s: 10") + kGuess, "at least the length of a session");
  expect(edited(good, "memory: 0.6", "memory: 1") + kGuess, "0 to 0.999");
  expect(good + kGuess + "causes: [torque-constant-heating]\n", "needs");
  expect(good + kGuess + "causes: [gremlins]\n", "gremlins");
  expect(good + kGuess + "causes: [coulomb-offset]\n", "is part of the law");
  expect(good + kGuess + "causes: [bend-friction, current-bias, bend-friction]\n", "found bend-friction a second time");
  expect(good + kGuess + "colour: red\n", "colour");
}

/// The figures of docs/studies/drives.md.
TEST(SlowBenchProtocol, AgainstThePapersProtocolAtEqualDuration) {
  constexpr int kLogs = 40;
  for (const double bristles : {0.0, 0.02}) {
    for (const double seconds : {300.0, 1000.0}) {
      FrictionTruth truth = benchTruth();
      truth.bristle_travel = bristles;
      const BenchProtocol protocol = protocolFor(limitsYaml(seconds) + kGuess);
      const Reached designed = fitsOf([&](int seed) { return recorded(protocol, truth, seed); }, truth, kLogs);
      const Reached paper = fitsOf(
          [&](int seed) {
            return simulateFrictionLog(truth, {.rows = static_cast<std::size_t>(50.0 * seconds),
                                               .sessions = static_cast<int>(seconds / 20.0),
                                               .seed = static_cast<std::uint64_t>(seed)});
          },
          truth, kLogs);
      std::map<std::string, double> expected;
      std::printf(
          "%g s, bristles of %g rad: parameter, expected sd, stated, RMS error; stated and RMS error on the "
          "paper's protocol\n",
          seconds, bristles);
      for (const Estimate& e : protocol.precision.expected) {
        expected[e.name] = e.sd;
        std::printf("  %-6s %.4g %.4g %.4g; %.4g %.4g\n", e.name.c_str(), e.sd, designed.stated.at(e.name),
                    designed.error.at(e.name), paper.stated.at(e.name), paper.error.at(e.name));
      }
      std::printf("  stated / expected %.2f; error / expected %.2f; paper's stated / designed %.2f, errors %.2f\n",
                  meanRatio(designed.stated, expected), meanRatio(designed.error, expected),
                  meanRatio(paper.stated, designed.stated), meanRatio(paper.error, designed.error));
      EXPECT_GT(meanRatio(paper.stated, designed.stated), 1.0);
      if (bristles > 0.0) continue;  // which the law does not have: what is expected of it does not hold then
      EXPECT_NEAR(meanRatio(designed.stated, expected), 1.0, 0.2);
      EXPECT_NEAR(meanRatio(designed.error, expected), 1.0, 0.25);
      EXPECT_GT(meanRatio(paper.error, designed.error), 1.0);
    }
  }
}

}  // namespace
}  // namespace simgap::test
