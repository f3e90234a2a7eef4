// From effort to motion: against a drive that was integrated by itself in steps of 10 microseconds.
#include "simgap/fit/actuators/free_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "simgap/core/error.h"
#include "simgap/core/yaml.h"

namespace simgap::test {
namespace {

/// A slide of 20 kg with 30 N of dry and 150 N s/m of viscous friction, pushed by a force that reverses and pauses: it
/// sticks in the pauses. Every 5 ms a row.
std::string recordSlide() {
  constexpr double kMass = 20.0, kDry = 30.0, kViscous = 150.0, kStep = 1e-5;
  const auto force = [](double t) { return std::fmod(t, 4.0) < 1.0 ? 10.0 : 120.0 * std::sin(2.1 * t); };
  std::string text = "time_s,motor_force_N,position_m\n";
  double x = 0.05, v = 0.0;
  for (int i = 0; i <= 1'200'000; ++i) {
    const double t = kStep * i;
    if (i % 500 == 0) text += fmt::format("{:.3f},{:.9g},{:.9g}\n", t, force(t), x);
    // Set-valued friction: what it can hold it holds (Moreau 1988).
    const double free = v + kStep * (force(t) - kViscous * v) / kMass, most = kStep * kDry / kMass;
    v = std::abs(free) <= most ? 0.0 : free - std::copysign(most, free);
    x += kStep * v;
  }
  return text;
}

FittedModel slide() {
  FittedModel model;
  model.kind = "friction";
  model.law = "coulomb";
  model.parameters = {{"k_a", "1", 1.0}, {"tau_c", "N", 30.0}, {"k_v", "Ns_m", 150.0}, {"mass", "kg", 20.0}};
  return model;
}

Bench axis(const std::string& mass) {
  return readBench(
      YamlNode::parse("format: simgap/bench/1\nload: free-axis\n" + mass + "bandwidth_Hz: 40\n", "axis.yaml"));
}

TEST(FreeRun, FollowsAnIndependentIntegrationThroughRestsAndReversals) {
  const CsvTable log = CsvTable::parse(recordSlide(), "slide.csv");
  for (const char* mass : {"mass_kg: fit\n", "mass_kg: 20\n"}) {
    const Prediction run = runFreely(slide(), log, axis(mass));
    EXPECT_EQ(run.name, "position");
    EXPECT_EQ(run.unit, "m");
    ASSERT_EQ(run.predicted.size(), 2401u);
    EXPECT_LT(*rmsError(run), 1e-3) << "of a stroke of about 0.6 m";
  }
  FittedModel wrong = slide();
  wrong.parameters[1].value = 20.0;
  EXPECT_GT(*rmsError(runFreely(wrong, log, axis("mass_kg: 20\n"))), 1e-2) << "a wrong friction adds up";
}

TEST(FreeRun, RefusesWhatItCannotMove) {
  const CsvTable log = CsvTable::parse(recordSlide(), "slide.csv");
  EXPECT_THROW(runFreely(slide(), log, axis("mass_kg: 0\n")), Error);
  FittedModel remembers = slide();
  remembers.extensions = {{"backlash", "", {{"play", "rad", 0.01}}}};
  EXPECT_THROW(runFreely(remembers, log, axis("mass_kg: 20\n")), ConfigError);
  FittedModel muscle = slide();
  muscle.kind = "pam";
  muscle.law = "no-spring";
  EXPECT_THROW(runFreely(muscle, log, axis("mass_kg: 20\n")), ConfigError);
}

}  // namespace
}  // namespace simgap::test
