#include "simgap/measure/logs/bench.h"

#include <fmt/format.h>

#include <cmath>

namespace simgap {
namespace {

bool isToBeFitted(const YamlNode& root, const std::string& key) {
  return root.has(key) && root.at(key).isScalar() && root.at(key).text() == "fit";
}

/// A constant of the whole rig. \param otherwise  where the file does not state it.
BenchConstant constant(const YamlNode& root, const char* stem, const char* unit, const Range& range, double otherwise) {
  if (isToBeFitted(root, quantityName(stem, unit))) return {1.0, true};
  return {root.findQuantity(stem, unit, range).value_or(otherwise), false};
}

/// A session's own number for a constant of the rig.
BenchConstant sessionConstant(const YamlNode& node, const char* stem, const char* unit, const Range& range,
                              const BenchConstant& rig) {
  if (!node.hasQuantity(stem, unit)) return rig;
  if (rig.fitted) {
    node.fail(fmt::format("found {} for a session, expected none: it is fitted, and the same in all sessions",
                          quantityName(stem, unit)));
  }
  return {node.quantity(stem, unit, range), false};
}

void readPendulum(const YamlNode& root, Bench& bench) {
  bench.length = constant(root, "length", "m", kPositive, std::nan(""));
  bench.angle_offset = constant(root, "angle_offset", "rad", kAnyNumber, 0.0);
  bench.gravity = root.findQuantity("gravity", "m_s2", kPositive).value_or(bench.gravity);
}

BenchConstants readSession(const YamlNode& node, const Bench& bench) {
  BenchConstants own = bench;
  own.mass = sessionConstant(node, "mass", "kg", kNonNegative, bench.mass);
  own.inertia = sessionConstant(node, "inertia", "kg_m2", kNonNegative, bench.inertia);
  if (bench.load == BenchLoad::kPendulum) {
    own.length = sessionConstant(node, "length", "m", kPositive, bench.length);
    own.angle_offset = sessionConstant(node, "angle_offset", "rad", kAnyNumber, bench.angle_offset);
  }
  return own;
}

/// What no motion could tell apart, or nobody said. \param node  that the constants were read from.
void checkConstants(const YamlNode& node, BenchLoad load, const BenchConstants& c) {
  const bool nothing = !c.mass.fitted && !c.inertia.fitted && c.mass.value + c.inertia.value == 0.0;
  if (nothing) node.fail("found neither mass_kg nor inertia_kg_m2, expected one of them: a number, or 'fit'");
  if (load == BenchLoad::kPendulum && std::isnan(c.length.value)) {
    node.fail("found no length_m of the pendulum, expected a number, or 'fit'");
  }
  if (c.length.fitted && (c.mass.fitted || c.mass.value == 0.0)) {
    node.fail("found length_m: fit without a mass, expected mass_kg: a number (only mass times length acts)");
  }
  if (c.angle_offset.fitted && !c.mass.fitted && c.mass.value == 0.0) {
    node.fail("found angle_offset_rad: fit without a mass, expected mass_kg: a number, or 'fit'");
  }
}

void checkRig(const YamlNode& root, const Bench& bench) {
  if (!bench.fitsWholeInertia()) return;
  if (!bench.inertia.fitted) {
    root.fail("found m l to be fitted and inertia_kg_m2 not, expected inertia_kg_m2: fit (it takes m l^2 in)");
  }
  for (const auto& [name, own] : bench.sessions) {
    const bool other = own.mass.value != bench.mass.value ||
                       (!bench.length.fitted && own.length.value != bench.sessions.begin()->second.length.value);
    if (other) root.fail("found m l to be fitted for sessions whose m l^2 differ, expected it to be the same in all");
  }
}

}  // namespace

Bench readBench(const YamlNode& root) {
  Bench bench;
  root.at("format").oneOf({"simgap/bench/1"});
  const std::string load = root.at("load").oneOf({"torque-sensor", "pendulum", "free-axis"});
  bench.bandwidth = root.findQuantity("bandwidth", "Hz", kPositive);
  if (const auto ratio = root.find("transmission_ratio")) bench.ratio = ratio->number(kPositive);
  if (load == "pendulum") bench.load = BenchLoad::kPendulum;
  if (load == "free-axis") bench.load = BenchLoad::kFreeAxis;
  if (bench.load == BenchLoad::kPendulum) readPendulum(root, bench);
  if (bench.load != BenchLoad::kTorqueSensor) {
    bench.mass = constant(root, "mass", "kg", kNonNegative, 0.0);
    bench.inertia = constant(root, "inertia", "kg_m2", kNonNegative, 0.0);
    const auto sessions = root.find("sessions");
    for (const std::string& name : sessions ? sessions->keys() : std::vector<std::string>()) {
      const YamlNode node = sessions->at(name);
      const BenchConstants& own = bench.sessions[name] = readSession(node, bench);
      checkConstants(node, bench.load, own);
    }
    if (bench.sessions.empty()) checkConstants(root, bench.load, bench);
    checkRig(root, bench);
  }
  root.expectAllRead();
  return bench;
}

std::string weightlessSentence(const std::string& constant) {
  return fmt::format(
      "fitted {} at 0: the angle offset (angle_offset_rad) is probably wrong; let it be fitted (angle_offset_rad: fit)",
      constant);
}

}  // namespace simgap
