/// \file
/// Large arms: a pose of sixty muscles that bend over surfaces, and the calibration of a torso of twenty-two.
#include <benchmark/benchmark.h>

#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/posterior_search.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

const std::string kRoot = std::string(SIMGAP_SOURCE_DIR) + "/";

PoseSet posesOf(const ArmModel& model, const std::string& file) {
  return readPoseSet(CsvTable::load(kRoot + file), model.poseLayout());
}

/// The sample arm with its eleven muscles split into sixty, each of which bends over a ball in the shoulder or a roll
/// in the elbow.
ArmModel sixtyMuscles() {
  constexpr std::size_t kMuscles = 60;
  ArmModel model = readArm(YamlNode::load(kRoot + "data/arm/arm.yaml"));
  const std::vector<Muscle> drawn = model.muscles;
  model.muscles.clear();
  const Joint &shoulder = model.joints[0], &elbow = model.joints[1];
  model.bodies[shoulder.child].surfaces.push_back(
      {"ball", Surface::Shape::kSphere, 0.02, shoulder.child_position, Eigen::Vector3d::UnitZ()});
  model.bodies[elbow.parent].surfaces.push_back(
      {"roll", Surface::Shape::kCylinder, 0.015, elbow.parent_position, elbow.axis});
  for (std::size_t m = 0; m < kMuscles; ++m) {
    Muscle muscle = drawn[m % drawn.size()];
    const double apart = 1.5e-3 * static_cast<double>(m / drawn.size());
    muscle.name += "_" + std::to_string(m);
    for (Attachment& end : muscle.attachments) end.point.x() += apart;
    muscle.shock_cord.stiffness *= static_cast<double>(drawn.size()) / kMuscles;
    Station over;
    over.kind = Station::Kind::kSurface;
    over.at.body = muscle.attachments[0].body == elbow.parent ? elbow.parent : shoulder.child;
    muscle.between = {over};
    model.muscles.push_back(std::move(muscle));
  }
  return model;
}

void SixtyWrappedMuscles(benchmark::State& state) {
  const ArmModel drawn = readArm(YamlNode::load(kRoot + "data/arm/arm.yaml"));
  const PoseSet set = posesOf(drawn, "data/arm-dense/poses_calibration.csv");
  EquilibriumArm arm(sixtyMuscles());
  std::vector<std::vector<double>> shafts;
  for (const Pose& pose : set.poses) {
    shafts.emplace_back();
    for (std::size_t m = 0; m < 60; ++m) shafts.back().push_back(pose.shafts[m % pose.shafts.size()]);
  }
  long iterations = 0, stable = 0;
  for (auto _ : state) {
    for (std::size_t p = 0; p < shafts.size(); ++p) {
      const EquilibriumSolution solution = arm.solveFrom(set.poses[p].joints, shafts[p]);
      iterations += solution.iterations;
      stable += solution.stable;
    }
  }
  const auto solved = static_cast<double>(state.iterations()) * static_cast<double>(shafts.size());
  state.counters["evaluations"] = static_cast<double>(iterations) / solved;
  state.counters["stable"] = static_cast<double>(stable) / solved;
  state.counters["pose"] = benchmark::Counter(
      static_cast<double>(shafts.size()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(SixtyWrappedMuscles)->Unit(benchmark::kMicrosecond);

/// 198 parameters on 30 poses, eight starts.
void CalibrateTorso(benchmark::State& state) {
  const ArmModel model = readArm(YamlNode::load(kRoot + "data/torso/arm.yaml"));
  const PoseSet set = posesOf(model, "data/torso/poses_both.csv");
  const CalibrationConfig config = CalibrationConfig::read(YamlNode::load(kRoot + "configs/calibrate_arm.yaml"));
  const ParameterSpace space(model, config.parameters);
  for (auto _ : state) {
    PosePosterior posterior(model, set.poses, space, config.noise);
    benchmark::DoNotOptimize(searchPosterior(posterior, {config.starts, 1, 1}).front().objective);
  }
  state.counters["parameters"] = static_cast<double>(space.size());
  state.counters["starts"] = config.starts;
}
BENCHMARK(CalibrateTorso)->Unit(benchmark::kSecond)->Iterations(1)->MeasureProcessCPUTime();

}  // namespace
}  // namespace simgap
