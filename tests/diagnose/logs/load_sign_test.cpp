// The load of a slide is its mass times an acceleration that comes from counts of a position: most of the time it is
// noise, which decides its sign, and which the prediction M a / k_a has in it as well.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "prepared_logs.h"
#include "simgap/core/csv.h"
#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap::test {
namespace {

/// A screw that carries 38 kg from place to place, with rests: 1.2 m/s^2, counts of 20 um, friction of 24 N and
/// 85 N s/m, 45 N/A.
std::string slide(std::uint64_t seed) {
  constexpr double kStep = 0.004, kRate = 1.2, kCount = 2e-5;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise;
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(engine); };
  CsvWriter csv({"time_s", "position_m", "motor_current_A"});
  double place = 0.0, time = 0.0;
  while (time < 48.0) {
    const double goal = uniform(-0.2, 0.2), way = std::abs(goal - place), sign = goal > place ? 1.0 : -1.0;
    const double wanted = std::exp(uniform(std::log(0.02), std::log(0.25))),
                 top = std::min(wanted, std::sqrt(way * kRate));
    const double ramp = top / kRate, end = way / top + ramp, rest = uniform(0.2, 1.2);
    for (double within = 0.0; within < end + rest; within += kStep, time += kStep) {
      const double left = end - within;
      const bool starts = within < ramp, stops = left < ramp && left > 0.0;
      const double acceleration = starts ? kRate : stops ? -kRate : 0.0;
      const double speed = starts ? kRate * within : stops ? kRate * left : left > 0.0 ? top : 0.0;
      const double gone = starts       ? 0.5 * kRate * within * within
                          : left > 0.0 ? (stops ? way - 0.5 * kRate * left * left : top * (within - 0.5 * ramp))
                                       : way;
      const double friction = left > 0.0 ? 24.0 + 85.0 * speed : 0.0;
      const double current = sign * (38.0 * acceleration + friction) / 45.0 + 0.04 * noise(engine);
      csv.add(time).add(kCount * std::round((place + sign * gone) / kCount)).add(0.005 * std::round(current / 0.005));
      csv.endRow();
    }
    place = goal;
  }
  return csv.text();
}

bool namesBackdriving(const Diagnosis& diagnosis) {
  return std::ranges::any_of(diagnosis.causes, [](const Cause& c) { return c.effect == "backdrive-asymmetry"; });
}

TEST(LoadSign, OfALoadThatIsNoiseIsNoCause) {
  const Bench bench =
      readBench(YamlNode::parse("format: simgap/bench/1\nload: free-axis\nmass_kg: 38\n", "bench.yaml"));
  for (const std::uint64_t seed : {1u, 2u}) {
    PreparedLog log = prepareLog(CsvTable::parse(slide(seed), "log.csv"), bench, ActuatorKind::kFriction);
    LogDiagnosisOptions options;
    options.effects = {"backdrive-asymmetry"};
    const Diagnosis found = diagnoseLog(subjectOf("coulomb"), log, options).diagnosis;
    EXPECT_FALSE(namesBackdriving(found)) << found.sentence;
    ASSERT_EQ(found.candidates.size(), 1u);
    EXPECT_NE(found.candidates[0].reason.find("where the load is clear"), std::string::npos)
        << found.candidates[0].reason;
  }
}

TEST(LoadSign, OfALoadThatIsClearIsOne) {
  reality::DriveSecret secret;
  secret.backdrive_share = 0.3;
  PreparedLog log = preparedLog(smallRig(6000), secret);
  LogDiagnosisOptions options;
  options.effects = {"backdrive-asymmetry"};
  const Diagnosis found = diagnoseLog(subjectOf("classic"), log, options).diagnosis;
  EXPECT_TRUE(namesBackdriving(found)) << found.sentence;
}

}  // namespace
}  // namespace simgap::test
