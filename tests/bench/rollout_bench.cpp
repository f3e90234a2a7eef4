// What a simulated second of the 11-muscle arm costs at a step of 1 ms.
#include <benchmark/benchmark.h>

#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/rollout.h"

namespace {

void playSecond(benchmark::State& state) {
  const simgap::ArmModel model = simgap::readArm(simgap::YamlNode::load(SIMGAP_SOURCE_DIR "/data/arm/arm.yaml"));
  simgap::Rollout rollout(model, {});
  simgap::MotionCommands commands;
  commands.kinds.assign(model.muscles.size(), simgap::CommandKind::kSetpoint);
  commands.times = {0.0};
  commands.values = Eigen::MatrixXd::Constant(std::ssize(model.muscles), 1, 2.0);
  std::vector<double> times;
  for (int i = 0; i <= 100; ++i) times.push_back(0.01 * i);
  simgap::MotionTrack track;
  for (auto _ : state) benchmark::DoNotOptimize(rollout.run(commands, {}, times, track));
}
BENCHMARK(playSecond)->Unit(benchmark::kMillisecond);

}  // namespace
