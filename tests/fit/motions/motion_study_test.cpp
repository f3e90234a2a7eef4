// How honest a calibration on motions is: arms drawn and moved by an independent simulator, their models off by what a
// static calibration and data sheets leave. The table of docs/studies/motions.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "reality/arm_motion.h"
#include "simgap/core/random.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "support/files.h"
#include "support/motion_draws.h"
#include "support/statics.h"

namespace simgap {
namespace {

constexpr std::uint64_t kFirstArm = 41, kMovingArms = 20;  // forms were found on arms 1 to 40

/// A drawn arm as it is believed to be and as it is.
struct DrawnArm {
  reality::MovingArm nominal, truth;
};

DrawnArm drawArm(std::uint64_t seed) {
  test::Deviations deviations(seed, 91);
  DrawnArm drawn;
  reality::RandomArmOptions options;
  options.max_links = 2;
  options.max_muscles = 8;
  drawn.nominal.arm = reality::randomArm(1000 + seed, options);
  drawn.nominal.drives.resize(drawn.nominal.arm.muscles.size());
  drawn.truth = drawn.nominal;
  test::deviate(drawn.truth.arm, deviations);
  reality::DriveTruth common;
  deviations.scale(common.gear_coulomb, 0.3);
  deviations.scale(common.viscous, 0.3);
  deviations.scale(common.inertia, 0.1);
  deviations.scale(common.gear_viscous, 0.3);
  deviations.scale(common.efficiency, 0.05);
  for (reality::DriveTruth& drive : drawn.truth.drives) {
    drive = common;
    deviations.scale(drive.coulomb, 0.3);
  }
  return drawn;
}

/// The true arm as a model: only to look up what each parameter should have been.
ArmModel trueModel(const reality::MovingArm& truth) {
  ArmModel model = test::modelOf(truth.arm, true);
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    const reality::DriveTruth& drive = truth.drives[m];
    Motor& motor = model.muscles[m].motor;
    Gearbox& gearbox = model.muscles[m].gearbox;
    motor.coulomb_friction = drive.coulomb;
    motor.viscous_friction = drive.viscous;
    motor.inertia = drive.inertia;
    gearbox.coulomb_friction = drive.gear_coulomb;
    gearbox.viscous_friction = drive.gear_viscous;
    gearbox.efficiency = drive.efficiency;
  }
  return model;
}

/// `count` recorded movements of the true arm.
MotionSet record(const reality::MovingArm& truth, const ArmModel& model, std::uint64_t first, std::size_t count,
                 const reality::MotionRigOptions& options) {
  const auto movement = [&](std::uint64_t draw) {
    return test::swingsBetweenRests(truth.arm, draw, {0.5, 1.5, 0.4, 2.8, 92});
  };
  return test::recordMotions(truth, model, movement, first, count, options);
}

bool isDynamic(const std::string& name) {
  return std::ranges::any_of(std::array{"damping", "friction", "inertia", "efficiency"},
                             [&](const char* word) { return name.find(word) != std::string::npos; });
}

struct Count {
  int right = 0, of = 0;
  void add(bool hit) {
    right += hit;
    ++of;
  }
  double part() const { return static_cast<double>(right) / of; }
};

/// Errors held out, and what was predicted of them.
struct Predicted {
  Count within, below;
  std::vector<double> ratios;  ///< root mean square over noise
  std::vector<double> widths;  ///< of the interval, of its middle

  void add(double rms, double low, double high, double noise) {
    within.add(low <= rms && rms <= high);
    below.add(rms < low);
    ratios.push_back(rms / noise);
    widths.push_back(2.0 * (high - low) / (high + low));
  }
};

struct StudyFigures {
  Count dynamic, fixed;
  Predicted joints, shafts, currents;
};

void calibrateDrawnArm(std::uint64_t seed, StudyFigures& figures) {
  const DrawnArm drawn = drawArm(seed);
  reality::MotionRigOptions options;
  options.capture_delay = 0.015;
  const ArmModel model = test::modelOf(drawn.nominal.arm, true), truth = trueModel(drawn.truth);
  MotionCalibrationTask task{
      model,
      MotionCalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_motions.yaml"))),
      record(drawn.truth, model, 100 * seed, 6, options),
      {},
      record(drawn.truth, model, 100 * seed + 50, 6, options)};
  MotionCalibration calibration(task);
  const MotionCalibrationResult result = judgeMotions(task, calibration, calibration.run({}, [](const auto&) {}));
  const ParameterSpace true_values(truth, task.config.parameters);
  Count dynamic, fixed;
  for (std::size_t p = 0; p < result.parameters.size(); ++p) {
    const MotionParameter& found = result.parameters[p];
    const bool last = p + 1 == result.parameters.size();
    const double right = last ? options.capture_delay : true_values.parameters()[p].initial;
    const bool covered = std::abs(found.value - right) <= 1.96 * found.sd;
    (last || isDynamic(found.name) ? dynamic : fixed).add(covered);
    (last || isDynamic(found.name) ? figures.dynamic : figures.fixed).add(covered);
    if (!covered && isDynamic(found.name)) {
      std::printf("    %s: %.4g +- %.2g, true %.4g, from %.4g\n", found.name.c_str(), found.value, found.sd, right,
                  found.initial);
    }
  }
  const MotionSetResult& unseen = result.sets[1];
  std::printf("arm %lu: %zu muscles, %zu rounds%s, misfit %.2f; dynamic %d of %d, static %d of %d;", seed,
              model.muscles.size(), result.state.descent.history.size(), result.failure.empty() ? "" : ", FAILED",
              result.misfit, dynamic.right, dynamic.of, fixed.right, fixed.of);
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const double rms = unseen.final.joints[j], low = unseen.lower->joints[j], high = unseen.upper->joints[j];
    figures.joints.add(rms, low, high, result.noise.joints[j]);
    std::printf(" %.2f -> %.3f deg (%.3f-%.3f, noise %.3f)", toDegrees(unseen.initial.joints[j]), toDegrees(rms),
                toDegrees(low), toDegrees(high), toDegrees(result.noise.joints[j]));
  }
  figures.shafts.add(unseen.final.shafts, unseen.lower->shafts, unseen.upper->shafts, result.noise.shafts);
  figures.currents.add(unseen.final.currents, unseen.lower->currents, unseen.upper->currents, result.noise.currents);
  std::printf("\n");
  std::fflush(stdout);
}

void printPredicted(const char* name, const Predicted& errors) {
  std::printf("%s: %.3f of %d within the predicted 5-95 %%, %d below; width %.3f, error %.3f of the noise (medians)\n",
              name, errors.within.part(), errors.within.of, errors.below.right, median(errors.widths),
              median(errors.ratios));
}

TEST(SlowMotionStudy, IntervalsOfDrawnArmsHold) {
  StudyFigures figures;
  for (std::uint64_t arm = 0; arm < kMovingArms; ++arm) calibrateDrawnArm(kFirstArm + arm, figures);
  std::printf("dynamic parameters covered %.3f of %d, static ones %.3f of %d\n", figures.dynamic.part(),
              figures.dynamic.of, figures.fixed.part(), figures.fixed.of);
  printPredicted("joints", figures.joints);
  printPredicted("shafts", figures.shafts);
  printPredicted("currents", figures.currents);
  EXPECT_GE(figures.dynamic.part(), 0.85);
  EXPECT_GE(figures.joints.within.part(), 0.85);
  EXPECT_LE(median(figures.joints.ratios), 1.5);
}

}  // namespace
}  // namespace simgap
