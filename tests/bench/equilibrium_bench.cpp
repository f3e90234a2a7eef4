/// \file
/// A pose by energy minimisation beside the same pose by the Bullet protocol, and what its sensitivities cost.
#include <benchmark/benchmark.h>

#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/pose_protocol.h"

namespace simgap {
namespace {

const std::string kData = std::string(SIMGAP_SOURCE_DIR) + "/data/";

struct Sample {
  ArmModel model = readArm(YamlNode::load(kData + "arm/arm.yaml"));
  PoseSet set = readPoseSet(CsvTable::load(kData + "arm-dense/poses_calibration.csv"), model.poseLayout());
};

void perPose(benchmark::State& state, std::size_t poses) {
  state.counters["pose"] = benchmark::Counter(
      static_cast<double>(poses), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Every pose from the arm's rest: what a search pays.
void SolvePose(benchmark::State& state) {
  const Sample sample;
  EquilibriumArm arm(sample.model);
  long iterations = 0;
  for (auto _ : state) {
    for (const Pose& pose : sample.set.poses) iterations += arm.solve(pose.shafts).iterations;
    benchmark::DoNotOptimize(arm.joints().data());
  }
  state.counters["evaluations"] =
      static_cast<double>(iterations) / static_cast<double>(state.iterations() * sample.set.poses.size());
  perPose(state, sample.set.poses.size());
}
BENCHMARK(SolvePose)->Unit(benchmark::kMicrosecond);

/// Every pose from the measured one: what a fit pays.
void SolvePoseFromMeasured(benchmark::State& state) {
  const Sample sample;
  EquilibriumArm arm(sample.model);
  for (auto _ : state) {
    for (const Pose& pose : sample.set.poses) arm.solveFrom(pose.joints, pose.shafts);
    benchmark::DoNotOptimize(arm.joints().data());
  }
  perPose(state, sample.set.poses.size());
}
BENCHMARK(SolvePoseFromMeasured)->Unit(benchmark::kMicrosecond);

/// d(pose)/d(all 99 parameters) at a solution.
void Sensitivities(benchmark::State& state) {
  const Sample sample;
  std::vector<std::string> names;
  for (const Muscle& muscle : sample.model.muscles) {
    for (const char* member : {"attachments.0.point_m.x", "attachments.0.point_m.y", "attachments.0.point_m.z",
                               "attachments.1.point_m.x", "attachments.1.point_m.y", "attachments.1.point_m.z",
                               "kite_line_length_m", "shock_cord.stiffness_N_m", "spindle_radius_m"}) {
      names.push_back("muscles." + muscle.name + "." + member);
    }
  }
  const std::vector<StaticParameter> parameters = staticParameters(sample.model, names);
  EquilibriumArm arm(sample.model);
  Eigen::MatrixXd columns(arm.energy().degreesOfFreedom(), parameters.size());
  arm.solve(sample.set.poses.front().shafts);
  for (auto _ : state) {
    arm.linearise();
    arm.sensitivities(parameters, columns);
    benchmark::DoNotOptimize(columns.data());
  }
}
BENCHMARK(Sensitivities)->Unit(benchmark::kMicrosecond);

void BulletPose(benchmark::State& state) {
  const Sample sample;
  PoseProtocol protocol;
  BulletArm arm(sample.model, protocol.arm);
  for (auto _ : state) {
    for (std::size_t p = 0; p < 15; ++p)
      benchmark::DoNotOptimize(replayPose(arm, sample.set.poses[p].shafts, protocol));
  }
  perPose(state, 15);
}
BENCHMARK(BulletPose)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace simgap
