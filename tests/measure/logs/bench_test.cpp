// Rigs whose constants change from session to session.
#include "simgap/measure/logs/bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/measure/logs/friction_rows.h"
#include "support/current_log.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

Bench pendulum(const std::string& keys) {
  Bench bench =
      readBench(YamlNode::parse("format: simgap/bench/1\nload: pendulum\nbandwidth_Hz: 20\n" + keys, "rig.yaml"));
  bench.file = "rig.yaml";
  return bench;
}

/// The same slow swing in every session: its load is the weight, next to nothing of it inertia.
ActuatorLog swings(const std::vector<std::string>& sessions) {
  ActuatorLog log = test::currentLog("log.csv");
  log.session_names = sessions;
  for (int s = 0; s < static_cast<int>(sessions.size()); ++s) {
    for (int i = 0; i < 2000; ++i) {
      const double t = 0.01 * i;
      log.time.push_back(t);
      log.position.push_back(std::sin(t));
      log.velocity.push_back(std::cos(t));
      log.effort.push_back(std::sin(t) + std::copysign(0.1, std::cos(t)));
      log.session.push_back(s);
    }
  }
  return log;
}

FrictionData prepared(const Bench& bench, const std::vector<std::string>& sessions) {
  FrictionDataOptions options;
  options.all_rows = true;
  return prepareFrictionData(swings(sessions), bench, options);
}

TEST(Bench, EachSessionHasItsOwnConstants) {
  const Bench bench = pendulum(
      "mass_kg: 2\nlength_m: 0.3\nangle_offset_rad: 0.2\nsessions: {light: {mass_kg: 0.5}, long: {length_m: 0.6, "
      "angle_offset_rad: 0}, same: {}}\n");
  const FrictionData data = prepared(bench, {"same", "light", "long"});
  const double l[] = {0.3, 0.3, 0.6}, m[] = {2.0, 0.5, 2.0}, offset[] = {0.2, 0.2, 0.0};
  for (int s = 0; s < 3; ++s) {
    for (const int i : {300, 900, 1500}) {
      const double t = 0.01 * i, angle = std::sin(t), acceleration = -std::sin(t);
      const double load = m[s] * 9.81 * l[s] * std::sin(angle - offset[s]) + m[s] * l[s] * l[s] * acceleration;
      EXPECT_NEAR(data.load[2000 * s + i], load, 2e-3) << s << " " << i;
    }
  }
}

TEST(Bench, OneUnknownInertiaUnderDifferentMasses) {
  const Bench bench = pendulum("length_m: 0.3\ninertia_kg_m2: fit\nsessions: {a: {mass_kg: 1}, b: {mass_kg: 2}}\n");
  const FrictionData data = prepared(bench, {"a", "b"});
  EXPECT_EQ(data.rig_names, std::vector<std::string>{"inertia"});
  EXPECT_NEAR(data.load[2300] / data.load[300], 2.0, 1e-9);
}

TEST(Bench, SaysWhatIsMissingOrCannotBe) {
  const auto error = [](const std::string& keys) { return errorOf([&] { pendulum(keys); }); };
  EXPECT_THAT(error("mass_kg: 1\nsessions: {a: {length_m: 1}, b: {}}\n"),
              HasSubstr("found no length_m of the pendulum"));
  EXPECT_THAT(error("length_m: 1\nsessions: {a: {}}\n"), HasSubstr("found neither mass_kg nor inertia_kg_m2"));
  EXPECT_THAT(error("length_m: 1\nmass_kg: fit\nsessions: {a: {mass_kg: 1}}\n"),
              HasSubstr("found mass_kg for a session, expected none: it is fitted"));
  EXPECT_THAT(error("length_m: 1\nmass_kg: 1\nsessions: {a: {mass_g: fit}}\n"), HasSubstr("mass_g"));
  EXPECT_THAT(error("length_m: 1\nmass_kg: 1\nsessions: {a: {height_m: 1}}\n"), HasSubstr("height_m"));
  EXPECT_THAT(error("mass_kg: 1\nlength_m: fit\ninertia_kg_m2: fit\nsessions: {a: {mass_kg: 2}}\n"),
              HasSubstr("whose m l^2 differ"));
  const Bench bench = pendulum("length_m: 1\nsessions: {a: {mass_kg: 1}, b: {mass_kg: 2}}\n");
  EXPECT_THAT(errorOf([&] {
                prepared(bench, {"a", "c"});
              }),
              HasSubstr("rig.yaml: found no entry for session c of log.csv under sessions, expected one beside a, b"));
}

}  // namespace
}  // namespace simgap::test
