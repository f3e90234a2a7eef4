// How well descent with priors calibrates fresh arms, and what designed poses gain. Tables for
// docs/studies/calibrations.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "simgap/fit/poses/pose_design.h"
#include "simgap/fit/poses/posterior_search.h"
#include "support/rig.h"

namespace simgap {
namespace {

constexpr int kCalibratedArms = 20;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

struct Fitted {
  Eigen::VectorXd z;
  ArmModel model;
};

Fitted fitDrawn(PosePosterior& posterior) {
  const auto fits = searchPosterior(posterior);
  const auto best = std::min_element(fits.begin(), fits.end(),
                                     [](const auto& a, const auto& b) { return a.objective < b.objective; });
  EXPECT_TRUE(std::isfinite(best->objective));
  posterior.whiten(best->z);
  return {best->z, posterior.modelAt(best->z)};
}

struct Summary {
  std::vector<double> nominal[2], calibration[2], validation[2], predicted[2];
  int covered[2] = {0, 0};
};

Summary calibrateArms(const reality::RigOptions& options) {
  Summary summary;
  for (int seed = 0; seed < kCalibratedArms; ++seed) {
    const test::RecordedRig rig = test::recordRig(static_cast<std::uint64_t>(seed), options);
    const ParameterSpace space = test::paperParameters(rig.model);
    PosePosterior posterior(rig.model, rig.calibration, space, {});
    const Fitted found = fitDrawn(posterior);
    const PoseUncertainty uncertainty = assessUncertainty(posterior, found.z, space);
    const PredictedError predicted = predictError(posterior, found.z, uncertainty, rig.validation);
    const auto before = test::meanJointErrors(rig.model, rig.validation);
    const auto calibration = test::meanJointErrors(found.model, rig.calibration);
    const auto validation = test::meanJointErrors(found.model, rig.validation);
    for (std::size_t j = 0; j < 2; ++j) {
      summary.nominal[j].push_back(before[j]);
      summary.calibration[j].push_back(calibration[j]);
      summary.validation[j].push_back(validation[j]);
      summary.predicted[j].push_back(toDegrees(predicted.mean[j]));
      summary.covered[j] +=
          validation[j] >= toDegrees(predicted.lower[j]) && validation[j] <= toDegrees(predicted.upper[j]);
    }
    std::cout << "  arm " << seed << ": nominal " << before[0] << " / " << before[1] << ", validation " << validation[0]
              << " / " << validation[1] << ", predicted " << summary.predicted[0].back() << " / "
              << summary.predicted[1].back() << "\n";
  }
  return summary;
}

void print(const char* name, const Summary& s) {
  std::cout << name << ", medians of " << kCalibratedArms << " arms [deg], shoulder / elbow: nominal "
            << median(s.nominal[0]) << " / " << median(s.nominal[1]) << ", calibration " << median(s.calibration[0])
            << " / " << median(s.calibration[1]) << ", validation " << median(s.validation[0]) << " / "
            << median(s.validation[1]) << ", predicted " << median(s.predicted[0]) << " / " << median(s.predicted[1])
            << "; within the 90 % interval " << s.covered[0] << " / " << s.covered[1] << "\n";
}

TEST(SlowCalibrationStudy, FreshArmsWithFifteenPoses) {
  const Summary summary = calibrateArms({});
  print("15 poses", summary);
  EXPECT_LE(median(summary.validation[0]), 2.2);
  EXPECT_LE(median(summary.validation[1]), 1.0);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LE(median(summary.validation[j]), 1.2 * median(summary.predicted[j])) << "joint " << j;
  }
}

TEST(SlowCalibrationStudy, FreshArmsWithFortyPoses) {
  reality::RigOptions options;
  options.calibration = 40;
  const Summary summary = calibrateArms(options);
  print("40 poses", summary);
  EXPECT_LE(median(summary.validation[0]), 1.6);
  EXPECT_LE(median(summary.validation[1]), 0.7);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LE(median(summary.validation[j]), 1.2 * median(summary.predicted[j])) << "joint " << j;
  }
}

// Spindles that coil by 1 % of their radius per radian and cords that harden: the model knows of neither.
TEST(SlowCalibrationStudy, FreshArmsThatDoWhatTheModelDoesNot) {
  reality::RigOptions options;
  options.coiling = 0.01 * 0.006;
  options.hardening = 0.2;
  print("15 poses, unmodelled effects", calibrateArms(options));
}

TEST(SlowCalibrationStudy, DesignedPosesAreWorthMoreThanRandomOnes) {
  constexpr std::size_t kFirst = 8, kMore = 7;
  std::vector<double> gain, predicted_ratio, actual_ratio;
  for (int seed = 0; seed < kCalibratedArms; ++seed) {
    reality::RigOptions options;
    options.validation = 60;
    const reality::Rig truth = reality::makeRig(static_cast<std::uint64_t>(seed), options);
    const test::RecordedRig rig = test::recordRig(static_cast<std::uint64_t>(seed), options);
    const ParameterSpace space = test::paperParameters(rig.model);
    std::vector<Pose> poses(rig.calibration.begin(), rig.calibration.begin() + kFirst);
    PosePosterior first(rig.model, poses, space, {});
    const Fitted before = fitDrawn(first);
    const PoseDesign design = designPoses(first, before.z, space, {300, kMore, DesignCriterion::kPrediction, 1});
    for (const Pose& command : design.poses) {
      poses.push_back(test::poseOf(
          rig.model, reality::record(truth.truth, command.shafts, options, 900000 + poses.size()), command.name));
    }
    PosePosterior designed(rig.model, poses, space, {});
    PosePosterior random(rig.model, rig.calibration, space, {});
    const auto error_before = test::meanJointErrors(before.model, rig.validation);
    const auto error_designed = test::meanJointErrors(fitDrawn(designed).model, rig.validation);
    const auto error_random = test::meanJointErrors(fitDrawn(random).model, rig.validation);
    gain.push_back(1.0 - error_designed[0] / error_random[0]);
    predicted_ratio.push_back(design.after.back().mean[0] / design.before.mean[0]);
    actual_ratio.push_back(error_designed[0] / error_before[0]);
    std::cout << "  arm " << seed << ": 8 poses " << error_before[0] << ", 8 + 7 designed " << error_designed[0]
              << ", 15 random " << error_random[0] << "; predicted " << toDegrees(design.before.mean[0]) << " -> "
              << toDegrees(design.after.back().mean[0]) << "\n";
  }
  double mean = 0.0, squares = 0.0;
  for (const double g : gain) mean += g / kCalibratedArms;
  for (const double g : gain) squares += (g - mean) * (g - mean);
  const double half =
      2.09 * std::sqrt(squares / (kCalibratedArms - 1) / kCalibratedArms);  // t of 19 degrees of freedom
  std::cout << "designed over random: " << 100.0 * mean << " % smaller shoulder error (95 %: " << 100.0 * (mean - half)
            << " to " << 100.0 * (mean + half) << "); reduction predicted " << median(predicted_ratio) << ", actual "
            << median(actual_ratio) << "\n";
  EXPECT_LE(std::max(median(predicted_ratio) / median(actual_ratio), median(actual_ratio) / median(predicted_ratio)),
            1.5);
}

}  // namespace
}  // namespace simgap
