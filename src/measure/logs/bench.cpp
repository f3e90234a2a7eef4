#include "simgap/measure/logs/bench.h"

namespace simgap {
namespace {

bool isToBeFitted(const YamlNode& root, const std::string& key) {
  return root.has(key) && root.at(key).isScalar() && root.at(key).text() == "fit";
}

BenchConstant constant(const YamlNode& root, const char* stem, const char* unit) {
  if (isToBeFitted(root, quantityName(stem, unit))) return {1.0, true};
  return {root.findQuantity(stem, unit, kNonNegative).value_or(0.0), false};
}

void readPendulum(const YamlNode& root, Bench& bench) {
  bench.load = BenchLoad::kPendulum;
  bench.length.fitted = isToBeFitted(root, "length_m");
  if (!bench.length.fitted) bench.length.value = root.quantity("length", "m", kPositive);
  bench.angle_offset.fitted = isToBeFitted(root, "angle_offset_rad");
  if (!bench.angle_offset.fitted) bench.angle_offset.value = root.findQuantity("angle_offset", "rad").value_or(0.0);
  bench.gravity = root.findQuantity("gravity", "m_s2", kPositive).value_or(bench.gravity);
}

/// What no motion could tell apart.
void checkConstants(const YamlNode& root, const Bench& bench) {
  const bool nothing = !bench.mass.fitted && !bench.inertia.fitted && bench.mass.value + bench.inertia.value == 0.0;
  if (nothing) root.fail("found neither mass_kg nor inertia_kg_m2, expected one of them: a number, or 'fit'");
  if (bench.length.fitted && (bench.mass.fitted || bench.mass.value == 0.0)) {
    root.fail("found length_m: fit without a mass, expected mass_kg: a number (only mass times length acts)");
  }
  if (bench.angle_offset.fitted && !bench.mass.fitted && bench.mass.value == 0.0) {
    root.fail("found angle_offset_rad: fit without a mass, expected mass_kg: a number, or 'fit'");
  }
  if (bench.fitsWholeInertia() && !bench.inertia.fitted) {
    root.fail("found m l to be fitted and inertia_kg_m2 not, expected inertia_kg_m2: fit (it takes m l^2 in)");
  }
}

}  // namespace

Bench readBench(const YamlNode& root) {
  Bench bench;
  root.at("format").oneOf({"simgap/bench/1"});
  const std::string load = root.at("load").oneOf({"torque-sensor", "pendulum", "free-axis"});
  bench.bandwidth = root.findQuantity("bandwidth", "Hz", kPositive);
  if (const auto ratio = root.find("transmission_ratio")) bench.ratio = ratio->number(kPositive);
  if (load == "pendulum") readPendulum(root, bench);
  if (load == "free-axis") bench.load = BenchLoad::kFreeAxis;
  if (bench.load != BenchLoad::kTorqueSensor) {
    bench.mass = constant(root, "mass", "kg");
    bench.inertia = constant(root, "inertia", "kg_m2");
    checkConstants(root, bench);
  }
  root.expectAllRead();
  return bench;
}

}  // namespace simgap
