// What the posterior claims against what happens when the same is measured again, and verdicts on arms made for them.
#include "simgap/fit/poses/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "simgap/core/random.h"
#include "simgap/fit/poses/levenberg_marquardt.h"
#include "support/arms.h"
#include "support/rig.h"
#include "support/statics.h"

namespace simgap {
namespace {

using testing::Test;

TEST(SlowUncertainty, StandardDeviationsMatchTheErrorsOfRefits) {
  // Truth drawn from the priors, poses from the independent simulator, 0.3 deg of capture noise, a fit: 200 times.
  // Lines that are known to 3 mm: with 11 mm one fit in ten ends beside the truth, at another minimum, where no linear
  // uncertainty can hold.
  constexpr double kLine = 3e-3;
  constexpr int kRefits = 200;
  reality::RigOptions options;
  options.proximal = options.distal = options.stiffness = options.radius = 0.0;  // only the lines are unknown
  options.kite_line = kLine;
  options.friction = false;
  options.calibration = 10;
  options.validation = 0;
  const ArmModel nominal = test::recordRig(0, options).model;
  const ParameterSpace space(nominal, {{"muscles.*.kite_line_length_m", 2e-3, {}, {}, kLine, {}}});
  double squares = 0.0;
  int count = 0;
  for (int refit = 0; refit < kRefits; ++refit) {
    const reality::Rig rig = reality::makeRig(static_cast<std::uint64_t>(1000 + refit), options);
    std::vector<Pose> poses;
    for (const auto& repeats : rig.calibration) poses.push_back(test::poseOf(nominal, repeats.front(), "p"));
    PosePosterior posterior(nominal, poses, space, {options.capture_sd, false});
    const PosteriorFit fit =
        descendPosterior(posterior, balanceTorques(posterior, Eigen::VectorXd::Zero(posterior.parameters().size())));
    ASSERT_TRUE(std::isfinite(fit.objective));
    const PoseUncertainty uncertainty = assessUncertainty(posterior, fit.z, space);
    const std::vector<double> values = posterior.parameters().values(fit.z);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double error = (values[i] - rig.truth.muscles[i].kite_line) / uncertainty.parameters[i].sd;
      squares += error * error;
      ++count;
    }
  }
  const double ratio = std::sqrt(squares / count);
  std::cout << "errors are " << ratio << " standard deviations in the root mean square\n";
  EXPECT_NEAR(ratio, 1.0, 0.2);
}

struct Fixture {
  explicit Fixture(const std::vector<ParameterSpace::Choice>& choices, ArmModel model_, std::vector<Pose> poses_)
      : model(std::move(model_)), poses(std::move(poses_)), space(model, choices) {
    // The poses are the model's own, so that z = 0 is the fit.
    EquilibriumArm arm(model);
    for (Pose& pose : poses) {
      EXPECT_TRUE(arm.solve(pose.shafts).stable);
      pose.joints = arm.joints();
    }
    PosePosterior posterior(model, poses, space, {});
    uncertainty = assessUncertainty(posterior, Eigen::VectorXd::Zero(posterior.parameters().size()), space);
  }
  Verdict verdict(const std::string& name) const {
    for (std::size_t i = 0; i < space.size(); ++i) {
      if (space.parameters()[i].name == name) return uncertainty.parameters[i].verdict;
    }
    ADD_FAILURE() << name;
    return Verdict::kWeak;
  }
  ArmModel model;
  std::vector<Pose> poses;
  ParameterSpace space;
  PoseUncertainty uncertainty;
};

std::vector<Pose> manyPoses() {
  reality::RigOptions options;
  options.calibration = 40;
  return test::recordRig(2, options).calibration;
}

ParameterSpace::Choice choice(const std::string& pattern, double sd) { return {pattern, 0.1 * sd, {}, {}, sd, {}}; }

TEST(Identifiability, LineAndRestLengthAreKnownOnlyInSum) {
  const Fixture f(
      {choice("muscles.muscle9.kite_line_length_m", 0.011), choice("muscles.muscle9.shock_cord.rest_length_m", 0.011)},
      test::recordRig(2).model, manyPoses());
  ASSERT_EQ(f.uncertainty.combinations.size(), 1u);
  EXPECT_EQ(f.uncertainty.combinations[0].text,
            "kite_line_length_m and shock_cord.rest_length_m of muscle9: only their sum");
  EXPECT_TRUE(f.uncertainty.combinations[0].always);
  EXPECT_EQ(f.verdict("muscles.muscle9.kite_line_length_m"), Verdict::kNotIdentifiable);
  EXPECT_EQ(f.verdict("muscles.muscle9.shock_cord.rest_length_m"), Verdict::kNotIdentifiable);
  EXPECT_NEAR(f.uncertainty.parameters[0].sd, 0.011 / std::sqrt(2.0), 0.01 * 0.011);
}

TEST(Identifiability, AloneTheLineIsIdentifiable) {
  const Fixture f({choice("muscles.*.kite_line_length_m", 0.011)}, test::recordRig(2).model, manyPoses());
  EXPECT_TRUE(f.uncertainty.combinations.empty());
  for (const ParameterUncertainty& p : f.uncertainty.parameters) EXPECT_EQ(p.verdict, Verdict::kIdentifiable);
}

TEST(Identifiability, AMuscleThatIsAlwaysSlackTellsNothing) {
  ArmModel model = test::recordRig(2).model;
  model.muscles[4].kite_line_length += 0.5;
  const Fixture f({choice("muscles.*.kite_line_length_m", 0.011)}, model, manyPoses());
  const std::string slack = "muscles." + model.muscles[4].name + ".kite_line_length_m";
  EXPECT_EQ(f.verdict(slack), Verdict::kNotIdentifiable);
  EXPECT_EQ(f.verdict("muscles.muscle9.kite_line_length_m"), Verdict::kIdentifiable);
  ASSERT_EQ(f.uncertainty.combinations.size(), 1u);
  EXPECT_EQ(f.uncertainty.combinations[0].text, "kite_line_length_m of " + model.muscles[4].name + ": has no effect");
}

TEST(Identifiability, CollinearMusclesWoundAlikeCannotBeToldApart) {
  // A twin of the biceps beside it, always wound by the same angle.
  ArmModel model = test::recordRig(2).model;
  Muscle twin = model.muscles[8];
  twin.name = "twin";
  model.muscles.push_back(twin);
  std::vector<Pose> poses = manyPoses();
  for (Pose& pose : poses) pose.shafts.push_back(pose.shafts[8]);
  const Fixture f(
      {choice("muscles.muscle9.shock_cord.stiffness_N_m", 120), choice("muscles.twin.shock_cord.stiffness_N_m", 120)},
      model, poses);
  ASSERT_EQ(f.uncertainty.combinations.size(), 1u);
  EXPECT_EQ(f.uncertainty.combinations[0].text,
            "shock_cord.stiffness_N_m of muscle9, shock_cord.stiffness_N_m of twin: only their sum, with these poses");
  EXPECT_FALSE(f.uncertainty.combinations[0].always) << "wound differently they would be told apart";
  EXPECT_NE(f.verdict("muscles.twin.shock_cord.stiffness_N_m"), Verdict::kIdentifiable);
}

TEST(Identifiability, WhatMovesNoEquilibriumHasNoEffect) {
  const Fixture f(
      {choice("muscles.muscle9.shock_cord.damping_Ns_m", 5.0), choice("muscles.muscle9.kite_line_length_m", 0.011)},
      test::recordRig(2).model, manyPoses());
  EXPECT_EQ(f.verdict("muscles.muscle9.shock_cord.damping_Ns_m"), Verdict::kNotIdentifiable);
  EXPECT_EQ(f.verdict("muscles.muscle9.kite_line_length_m"), Verdict::kIdentifiable);
}

/// A cord that is just slack in the only pose: where it is taut the pose, where it is not the prior pushes it back.
TEST(Uncertainty, KnowsAnOptimumAtAKink) {
  constexpr double kKnown = 0.01;  // [m] sd of the line
  const PoseNoise noise{0.3 * kDegree, false};
  ArmModel model = test::exampleArm();
  const auto brachialis = std::ranges::find(model.muscles, "brachialis", &Muscle::name) - model.muscles.begin();
  double& line = model.muscles[static_cast<std::size_t>(brachialis)].kite_line_length;
  Pose pose;
  pose.name = "p";
  pose.shafts.assign(model.muscles.size(), 0.0);
  const auto restsAt = [&](double length) {
    line = length;
    EquilibriumArm arm(model);
    EXPECT_TRUE(arm.solve(pose.shafts).stable);
    pose.joints = arm.joints();
    return arm.energy().expansion(static_cast<std::size_t>(brachialis));
  };
  double taut = line - 0.1, slack = line + 0.1;
  ASSERT_GT(restsAt(taut), 0.0);
  while (slack - taut > 1e-9) (restsAt(0.5 * (taut + slack)) > 0.0 ? taut : slack) = 0.5 * (taut + slack);
  restsAt(taut - 1e-3);
  const double pulled = pose.joints[1].angle;
  restsAt(slack);
  pose.joints[1].angle -= 3.0 * noise.capture_sd * (pulled > pose.joints[1].angle ? 1.0 : -1.0);
  pose.spread.assign(2, 0.0);
  line = taut - 0.5 * kKnown;  // half a standard deviation into what is taut
  const ParameterSpace space(model, {{"muscles.brachialis.kite_line_length_m", 1e-3, {}, {}, kKnown, {}}});
  const std::vector<Pose> poses{pose};
  PosePosterior posterior(model, poses, space, noise);
  const auto distanceAt = [&](double z) {
    return assessUncertainty(posterior, Eigen::VectorXd::Constant(1, z), space).from_optimum;
  };
  EXPECT_LT(distanceAt(0.5 - 1e-5), kAtOptimum);  // the slope promises 3
  EXPECT_GT(distanceAt(0.0), kAtOptimum);
}

TEST(Prediction, WithoutCommandsThereIsNoneInPlaceOfAnErrorOfZero) {
  // Cords so short that every recorded pose stretches one beyond its linear range: no command like them may be drawn.
  ArmModel model = test::recordRig(2).model;
  for (Muscle& muscle : model.muscles) {
    muscle.kite_line_length += 0.99 * muscle.shock_cord.rest_length;
    muscle.shock_cord.rest_length *= 0.01;
  }
  const Fixture f({choice("muscles.*.kite_line_length_m", 0.011)}, model, manyPoses());
  const PosePosterior posterior(f.model, f.poses, f.space, {});
  const Eigen::VectorXd z = Eigen::VectorXd::Zero(posterior.parameters().size());
  const std::vector<Pose> commands = drawCommands(posterior, z, 20, 1);
  EXPECT_TRUE(commands.empty());
  EXPECT_TRUE(predictError(posterior, z, f.uncertainty, commands).mean.empty());
  const PredictedError recorded = predictError(posterior, z, f.uncertainty, f.poses);
  ASSERT_EQ(recorded.mean.size(), f.model.joints.size());
  for (const double mean : recorded.mean) EXPECT_GT(mean, 0.0);
}

}  // namespace
}  // namespace simgap
