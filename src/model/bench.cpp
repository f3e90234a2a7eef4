#include "simgap/model/bench.h"

namespace simgap {
namespace {

BenchConstant constant(const YamlNode& root, const char* stem, const char* unit) {
  const std::string key = quantityName(stem, unit);
  if (root.has(key) && root.at(key).isScalar() && root.at(key).text() == "fit") return {1.0, true};
  return {root.findQuantity(stem, unit, kNonNegative).value_or(0.0), false};
}

}  // namespace

Bench readBench(const YamlNode& root) {
  Bench bench;
  root.at("format").oneOf({"simgap/bench/1"});
  const std::string load = root.at("load").oneOf({"torque-sensor", "pendulum", "free-axis"});
  bench.bandwidth = root.findQuantity("bandwidth", "Hz", kPositive);
  if (const auto ratio = root.find("transmission_ratio")) bench.ratio = ratio->number(kPositive);
  if (load == "pendulum") {
    bench.load = BenchLoad::kPendulum;
    bench.length = root.quantity("length", "m", kPositive);
    bench.angle_offset = root.findQuantity("angle_offset", "rad").value_or(0.0);
    bench.gravity = root.findQuantity("gravity", "m_s2", kPositive).value_or(bench.gravity);
  }
  if (load == "free-axis") bench.load = BenchLoad::kFreeAxis;
  if (bench.load != BenchLoad::kTorqueSensor) {
    bench.mass = constant(root, "mass", "kg");
    bench.inertia = constant(root, "inertia", "kg_m2");
    const bool nothing = !bench.mass.fitted && !bench.inertia.fitted && bench.mass.value + bench.inertia.value == 0.0;
    if (nothing) root.fail("found neither mass_kg nor inertia_kg_m2, expected one of them: a number, or 'fit'");
  }
  root.expectAllRead();
  return bench;
}

}  // namespace simgap
