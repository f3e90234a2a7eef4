/// \file
/// What a pair of images costs once it is in memory, one thread, and OpenCV's labelling beside it.
#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include "support/capture_study.h"

namespace simgap {
namespace {

using test::camerasOf;
using test::matOf;
using test::targetsOf;

std::vector<reality::RenderedPair> movingArm(const reality::CaptureStage& stage, int ghosts) {
  std::vector<reality::RenderedPair> pairs;
  for (int i = 0; i < 20; ++i) {
    const auto pose = reality::between(reality::randomPose(1), reality::randomPose(2), i / 40.0);
    pairs.push_back(stage.render({pose}, {0.0, ghosts, false, 0.0}, std::uint64_t(i)));
  }
  return pairs;
}

/// Arguments: scale (1: 640x480, 2: 1280x960), ghosts per image, forget (1: no tracking).
void ProcessPair(benchmark::State& state) {
  cv::setNumThreads(1);
  const reality::CaptureStage stage(reality::standardLenses(int(state.range(0))), reality::standardTargets());
  const auto pairs = movingArm(stage, int(state.range(1)));
  StereoCapture capture(camerasOf(stage.lenses()), targetsOf(stage.targets()));
  std::size_t i = 0;
  std::size_t found = 0;
  for (auto _ : state) {
    const reality::RenderedPair& pair = pairs[i++ % pairs.size()];
    if (state.range(2) != 0) capture.forget();
    for (const TargetFrame& target : capture.process(matOf(pair.left), matOf(pair.right)).targets) {
      found += target.found;
    }
  }
  state.counters["targets"] = double(found) / double(state.iterations());
}
BENCHMARK(ProcessPair)
    ->ArgNames({"scale", "ghosts", "forget"})
    ->Args({1, 0, 0})
    ->Args({1, 0, 1})
    ->Args({1, 10, 0})
    ->Args({1, 20, 1})
    ->Args({2, 0, 0})
    ->Args({2, 0, 1})
    ->Args({2, 20, 1})
    ->Unit(benchmark::kMillisecond);

void ConnectedComponentsOfPair(benchmark::State& state) {
  cv::setNumThreads(1);
  const reality::CaptureStage stage(reality::standardLenses(int(state.range(0))), reality::standardTargets());
  const auto pair = stage.render({reality::randomPose(1)}, {}, 1);
  cv::Mat binary, labels, statistics, centroids;
  for (auto _ : state) {
    for (const auto* image : {&pair.left, &pair.right}) {
      cv::threshold(matOf(*image), binary, 50, 255, cv::THRESH_BINARY);
      benchmark::DoNotOptimize(cv::connectedComponentsWithStats(binary, labels, statistics, centroids));
    }
  }
}
BENCHMARK(ConnectedComponentsOfPair)->ArgName("scale")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace simgap
