// A capture's judgement of itself: a wrong calibration that still fits is named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "simgap/capture/capture_statistics.h"
#include "support/capture_study.h"

namespace simgap::test {
namespace {

using ::testing::IsEmpty;
using ::testing::Not;

const reality::StereoLenses kStudied = reality::standardLenses();

/// The doubts of a capture that believes `believed`, on images of the true cameras.
CaptureStatistics statisticsWith(const reality::StereoLenses& believed) {
  static const reality::CaptureStage stage(kStudied, reality::standardTargets());
  static const std::vector<reality::RenderedPair> pairs = [] {
    std::vector<reality::RenderedPair> all;
    for (std::uint64_t i = 0; i < 30; ++i) all.push_back(stage.render({reality::randomPose(i)}, {0.0, 3}, i));
    return all;
  }();
  const TargetSet targets = targetsOf(stage.targets());
  const double bar = (stage.targets()[0].markers[0] - stage.targets()[0].markers[3]).norm();
  const Rig rig{"", "", ScaleBar{{0, 0}, {0, 3}, bar}, {}};
  StereoCapture capture(camerasOf(believed), targets);
  CaptureStatistics statistics(camerasOf(believed), targets, rig);
  for (const auto& pair : pairs) {
    capture.forget();
    statistics.add(capture.process(matOf(pair.left), matOf(pair.right)), capture.centroidSd());
  }
  return statistics;
}

TEST(GeometryDoubts, NoneWithTheRightCalibration) {
  const CaptureStatistics statistics = statisticsWith(kStudied);
  EXPECT_THAT(statistics.doubts(), IsEmpty());
  EXPECT_LT(std::abs(statistics.scaleErrorPercent()), 0.02);
}

TEST(GeometryDoubts, AWrongCalibrationThatStillFitsIsCaught) {
  for (const Eigen::Vector3d axis : {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}) {
    for (const double sign : {-1.0, 1.0}) {
      reality::StereoLenses wrong = kStudied;
      wrong.rotation = Eigen::AngleAxisd(sign * 0.6e-3, axis).toRotationMatrix() * kStudied.rotation;
      for (reality::Lens* lens : {&wrong.left, &wrong.right}) {
        lens->fx *= 1.002;
        lens->fy *= 1.002;
      }
      const CaptureStatistics statistics = statisticsWith(wrong);
      SCOPED_TRACE(axis.transpose());
      for (std::size_t t = 0; t < 3; ++t) {
        EXPECT_GE(statistics.found(t), 28u);         // nothing looks wrong …
        EXPECT_LT(statistics.rms(t).rms(), 0.5e-3);  // … by the fit
      }
      const auto doubts = statistics.doubts();
      EXPECT_THAT(doubts, Not(IsEmpty()));
      for (const GeometryFinding& doubt : doubts) std::printf("  %s: %s\n", doubt.name.c_str(), doubt.sentence.c_str());
    }
  }
}

}  // namespace
}  // namespace simgap::test
