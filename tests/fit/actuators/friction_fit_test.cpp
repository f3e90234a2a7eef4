#include "simgap/fit/actuators/friction_fit.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "support/files.h"
#include "support/friction_logs.h"

namespace simgap::test {
namespace {

using reality::FrictionTruth;
using reality::LogDesign;
using reality::simulateFrictionLog;
using ::testing::HasSubstr;

FrictionTruth variantA(double noise = 0.0) {
  FrictionTruth truth;
  truth.sliding_offset = 0.6;
  truth.noise = noise;
  return truth;
}

FrictionFit fit(const char* law, const FrictionData& data, const FrictionFitOptions& options = {}) {
  return fitFriction(friction::find(law), data, options);
}

const Estimate& estimate(const FrictionFit& fit, std::string_view name) {
  return *std::ranges::find(fit.uncertainty.estimates, name, &Estimate::name);
}

class LawDerivativeTest : public testing::TestWithParam<const FrictionLaw*> {};

TEST_P(LawDerivativeTest, AgreeWithCentralDifferences) {
  FrictionData data = frictionData(simulateFrictionLog(variantA(0.1), {.rows = 400, .sessions = 4}));
  for (const bool predict_load : {false, true}) {
    using Names = std::vector<std::string>;
    for (const Names& rig : {Names{}, Names{"inertia"}, Names{"angle_offset"}, Names{"mass", "angle_offset"},
                             Names{"length", "angle_offset", "total_inertia"}}) {
      if (!rig.empty() && predict_load) continue;
      data.rig_names = rig;
      data.rig_units = Names(rig.size(), "1");
      data.fits_angle = std::ranges::find(rig, "angle_offset") != rig.end();
      const bool known_amplitude = data.fits_angle && rig.front() == "angle_offset";
      data.load_per.resize(data.load.size(), rig.size() + (known_amplitude ? 1 : 0));
      for (Eigen::Index k = 0; k < data.load_per.cols(); ++k) {
        data.load_per.col(k) =
            0.3 + 0.2 * static_cast<double>(k) + data.velocity * 0.01 * static_cast<double>(1 + k * k);
      }
      FrictionFitOptions options;
      options.offset = true;
      options.predict_load = predict_load;
      const LeastSquaresProblem problem = makeFrictionProblem(*GetParam(), data, options);
      std::vector<double> theta;
      for (const ParameterSpec& p : problem.parameters)
        theta.push_back(p.name == "v_s" ? 15.0 : 0.4 + 0.1 * static_cast<double>(theta.size()));
      const auto rows = static_cast<Eigen::Index>(data.rows());
      const Block all{0, data.rows()};
      Eigen::VectorXd r(rows), up(rows), down(rows);
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows, theta.size());
      Eigen::Ref<Eigen::MatrixXd> jacobian(j);
      problem.evaluate(theta, all, r, &jacobian);
      for (std::size_t k = 0; k < theta.size(); ++k) {
        const double step = 1e-6 * theta[k];
        std::vector<double> moved = theta;
        moved[k] = theta[k] + step;
        problem.evaluate(moved, all, up, nullptr);
        moved[k] = theta[k] - step;
        problem.evaluate(moved, all, down, nullptr);
        const Eigen::VectorXd difference = (up - down) / (2.0 * step);
        const auto column = j.col(k);
        // Central differences are good to the square of the step and the rounding of the residuals over it.
        EXPECT_LT((difference - column).cwiseAbs().maxCoeff(), 1e-6 * (1.0 + column.cwiseAbs().maxCoeff()))
            << problem.parameters[k].name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllLaws, LawDerivativeTest, testing::ValuesIn(friction::all().begin(), friction::all().end()),
                         [](const auto& instance) {
                           std::string name(instance.param->name);
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

TEST(FrictionFit, RecoversTheTruthFromNoiselessLogs) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const FrictionTruth truth = variantA();
    const FrictionFit found = fit("variant-a", frictionData(simulateFrictionLog(truth, {.rows = 8000, .seed = seed})));
    EXPECT_NEAR(found.value("k_a"), truth.torque_per_ampere, 1e-6 * truth.torque_per_ampere);
    EXPECT_NEAR(found.value("n_c1"), truth.sliding_per_load, 1e-6 * truth.sliding_per_load);
    EXPECT_NEAR(found.value("n_c2"), truth.sliding_offset, 1e-6 * truth.sliding_offset);
    EXPECT_NEAR(found.value("n_s"), truth.breakaway_per_load, 1e-6 * truth.breakaway_per_load);
    EXPECT_NEAR(found.value("k_v"), truth.viscous, 1e-6 * truth.viscous);
    EXPECT_NEAR(found.value("v_s"), truth.stribeck_velocity, 1e-6 * truth.stribeck_velocity);
    EXPECT_NEAR(found.value("delta"), truth.stribeck_exponent, 1e-6 * truth.stribeck_exponent);
  }
}

TEST(FrictionFit, ScalingTheCurrentScalesTheTorqueConstantBack) {
  FrictionData data = frictionData(simulateFrictionLog(variantA(0.3), {.rows = 4000}));
  const FrictionFit before = fit("variant-a", data);
  data.effort *= 3.0;
  const FrictionFit after = fit("variant-a", data);
  EXPECT_NEAR(after.value("k_a"), before.value("k_a") / 3.0, 1e-6 * before.value("k_a"));
  for (const char* name : {"n_c1", "n_c2", "n_s", "v_s", "delta"}) {
    EXPECT_NEAR(after.value(name), before.value(name), 1e-4 * before.value(name)) << name;
  }
  EXPECT_NEAR(after.mse, 9.0 * before.mse, 1e-9 * after.mse);
}

TEST(FrictionFit, MirroringAllMotionChangesNothing) {
  FrictionData data = frictionData(simulateFrictionLog(variantA(0.3), {.rows = 4000}));
  const FrictionFit before = fit("variant-b", data);
  data.effort = -data.effort;
  data.velocity = -data.velocity;
  data.direction = -data.direction;
  data.load = -data.load;
  const FrictionFit after = fit("variant-b", data);
  EXPECT_DOUBLE_EQ(after.mse, before.mse);
  for (const Estimate& e : before.uncertainty.estimates) EXPECT_DOUBLE_EQ(after.value(e.name), e.value) << e.name;
}

TEST(FrictionFit, OrderOfRowsDoesNotMatter) {
  const FrictionData data = frictionData(simulateFrictionLog(variantA(0.3), {.rows = 3000}));
  std::vector<Eigen::Index> order(data.rows());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::shuffle(order, std::mt19937_64(5));
  FrictionData shuffled = data;
  for (Eigen::ArrayXd FrictionData::*channel :
       {&FrictionData::effort, &FrictionData::velocity, &FrictionData::log_speed, &FrictionData::direction,
        &FrictionData::load}) {
    shuffled.*channel = Eigen::ArrayXd((data.*channel)(order));
  }
  FrictionFitOptions options;
  options.folds = 0;
  const FrictionFit before = fit("classic", data, options), after = fit("classic", shuffled, options);
  EXPECT_NEAR(after.mse, before.mse, 1e-12 * before.mse);
  for (const Estimate& e : before.uncertainty.estimates) EXPECT_NEAR(after.value(e.name), e.value, 1e-5 * e.value);
}

TEST(FrictionFit, ShowsThePapersPatternOnVariantA) {
  // Offset and noise fixed before looking: 1.2 N m, the paper's MSE of 0.76 A^2.
  FrictionTruth truth = variantA(std::sqrt(0.7624));
  truth.sliding_offset = 1.2;
  const FrictionData data = frictionData(simulateFrictionLog(truth, {.rows = 40000, .sessions = 20}));
  std::vector<FrictionFit> fits{fit("classic", data), fit("variant-a", data), fit("variant-b", data)};
  const std::size_t best = compareFits(fits);
  const double gain_a = 100.0 * (fits[0].mse - fits[1].mse) / fits[0].mse;
  const double gain_b = 100.0 * (fits[1].mse - fits[2].mse) / fits[0].mse;
  EXPECT_GT(gain_a, 10.0);
  EXPECT_LT(gain_a, 20.0);
  EXPECT_LT(std::abs(gain_b), 0.1);
  EXPECT_EQ(best, 1u);
  EXPECT_LT(*fits[1].mse_heldout, *fits[0].mse_heldout);
}

TEST(FrictionFit, SeesNoOffsetWhereThereIsNone) {
  FrictionTruth truth = variantA(std::sqrt(0.7624));
  truth.sliding_offset = 0.0;
  const FrictionData data = frictionData(simulateFrictionLog(truth, {.rows = 40000, .sessions = 20}));
  std::vector<FrictionFit> fits{fit("classic", data), fit("variant-a", data), fit("variant-b", data)};
  EXPECT_EQ(compareFits(fits), 0u);
  EXPECT_LT(100.0 * (fits[0].mse - fits[1].mse) / fits[0].mse, 0.1);
}

TEST(FrictionFit, BristlesAndNoisyVelocityDoNotHideTheLaw) {
  FrictionTruth truth = variantA(0.25);
  truth.noise_memory = 0.6;
  truth.velocity_noise = 0.15;
  truth.bristle_travel = 0.02;
  const FrictionData held = frictionData(simulateFrictionLog(truth, {.rows = 20000}));
  FrictionDataOptions raw;
  raw.raw_sign = true;
  const FrictionData paper = frictionData(simulateFrictionLog(truth, {.rows = 20000}), raw);
  const FrictionFit good = fit("variant-a", held);
  EXPECT_LT(good.mse, 1.15 * 0.0625);
  EXPECT_NEAR(good.value("n_c2"), truth.sliding_offset, 0.05);
  EXPECT_GT(fit("variant-a", paper).mse, 1.5 * good.mse) << "the raw sign of a noisy velocity should ruin the fit";
}

TEST(FrictionFit, KeepsUserBoundsAndFixedValues) {
  const FrictionData data = frictionData(simulateFrictionLog(variantA(0.3), {.rows = 4000}));
  FrictionFitOptions options;
  options.fixed = {{"k_a", 1.2}, {"delta", 2.0}};
  options.bounds = {{"n_c1", {0.3, 0.5}}, {"k_v", {0.0, 0.005}}};
  const FrictionFit found = fit("variant-a", data, options);
  EXPECT_EQ(found.value("k_a"), 1.2);
  EXPECT_EQ(found.value("delta"), 2.0);
  EXPECT_GE(found.value("n_c1"), 0.3);
  EXPECT_LE(found.value("k_v"), 0.005);
  EXPECT_TRUE(estimate(found, "k_v").at_bound);
  EXPECT_EQ(found.parameters, 5u);
}

TEST(FrictionFit, RobustLossIgnoresOutliers) {
  FrictionData data = frictionData(simulateFrictionLog(variantA(0.1), {.rows = 6000}));
  for (Eigen::Index i = 0; i < data.effort.size(); i += 37) data.effort[i] += 8.0;
  FrictionFitOptions options;
  const double plain = fit("variant-a", data, options).value("n_c2");
  options.loss = LossKind::kTukey;
  const double robust = fit("variant-a", data, options).value("n_c2");
  EXPECT_NEAR(robust, 0.6, 0.03);
  EXPECT_GT(std::abs(plain - 0.6), std::abs(robust - 0.6));
}

TEST(FrictionFit, FitsConstantsOfTheRig) {
  // A pendulum whose bob is unknown: the load is what its mass makes.
  FrictionTruth truth = variantA(0.05);
  const auto log = simulateFrictionLog(truth, {.rows = 6000, .sessions = 1});
  FrictionData data = frictionData(log);
  const double true_mass = 2.5;
  data.load_per = (data.load / true_mass).eval();
  data.load.setZero();
  data.rig_names = {"mass"};
  data.rig_units = {"kg"};
  FrictionFitOptions options;
  options.fixed = {{"k_a", truth.torque_per_ampere}};
  const FrictionFit found = fit("variant-a", data, options);
  EXPECT_NEAR(found.value("mass"), true_mass, 0.02);
  EXPECT_NEAR(found.value("n_c1"), truth.sliding_per_load, 0.02);
}

TEST(FrictionFit, SaysWhatTheLogCannotShow) {
  FrictionData data = frictionData(simulateFrictionLog(variantA(0.1), {.rows = 3000}));
  FrictionData idle = data;
  idle.load.setZero();
  EXPECT_THAT(errorOf([&] { fit("classic", idle); }), HasSubstr("k_a cannot be found: record with loads"));
  FrictionFitOptions fixed;
  fixed.fixed = {{"k_a", 1.3}};
  EXPECT_THAT(errorOf([&] { fit("classic", idle, fixed); }), HasSubstr("load-dependent friction of classic"));
  std::vector<bool> few(data.rows(), false);
  std::fill_n(few.begin(), 6, true);
  EXPECT_THAT(errorOf([&] { fit("variant-b", selectRows(data, few)); }), HasSubstr("6 usable rows for 8 parameters"));
  std::vector<bool> forward(data.rows());
  for (std::size_t i = 0; i < forward.size(); ++i) {
    forward[i] = data.direction[i] > 0.0 && data.load[i] > 0.0;
  }
  const FrictionFit one_way = fit("load-coulomb", selectRows(data, forward));
  EXPECT_THAT(one_way.warnings, testing::Contains(HasSubstr("one direction")));
  EXPECT_FALSE(estimate(one_way, "k_a").identifiable && estimate(one_way, "n_c1").identifiable &&
               !estimate(one_way, "k_a").at_bound && !estimate(one_way, "n_c1").at_bound);
}

/// A propeller's bench: motion in one direction, torque with the square of the speed, current with its cube.
TEST(FrictionFit, WhatMayHaveAnySizeIsNotDetermined) {
  std::string csv = "time_s,external_torque_Nm,motor_current_A,motor_velocity_rad_s\n";
  for (int row = 0; row < 48; ++row) {
    const double speed = 2600.0 * std::sqrt(row % 16 / 15.0) * (1.0 - 0.012 * (row / 16));
    const double torque = 1.55e-8 * speed * speed * (1.0 + 0.006 * (row / 16));
    csv += fmt::format("{},{:.6g},{:.6g},{:.6g}\n", 0.3 * row, torque, 0.02 + torque * speed / 17.5, speed);
  }
  const FrictionFit found =
      fit("stribeck", prepareFrictionData(readActuatorLog(CsvTable::parse(csv, "propeller.csv"), {}), {}, {}));
  for (const Estimate& e : found.uncertainty.estimates) {
    if (e.identifiable) EXPECT_LT(e.upper95, 1e50) << e.name;
  }
  EXPECT_FALSE(estimate(found, "k_a").identifiable);
  EXPECT_THAT(found.uncertainty.findings, testing::Contains(HasSubstr("cannot be found")));
}

TEST(FrictionFit, NamesTheStribeckVelocityWhenNothingIsSlow) {
  const FrictionData data = frictionData(simulateFrictionLog(variantA(0.1), {.rows = 8000}));
  std::vector<bool> fast(data.rows());
  for (std::size_t i = 0; i < fast.size(); ++i) fast[i] = std::abs(data.velocity[i]) > 80.0;
  const FrictionFit found = fit("variant-a", selectRows(data, fast));
  const bool flagged = !estimate(found, "v_s").identifiable || estimate(found, "v_s").at_bound ||
                       estimate(found, "v_s").sd > 0.3 * estimate(found, "v_s").value || !found.warnings.empty();
  EXPECT_TRUE(flagged) << testing::PrintToString(found.warnings);
}

TEST(FrictionFit, ThreadsDoNotChangeTheResult) {
  const FrictionData data = frictionData(simulateFrictionLog(variantA(0.3), {.rows = 9000}));
  const auto fitWith = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);  // more threads than cores, too
    return arena.execute([&] {
      EXPECT_EQ(tbb::this_task_arena::max_concurrency(), threads);
      return fit("variant-b", data);
    });
  };
  const FrictionFit one = fitWith(1);
  for (const int threads : {2, 3, 8}) {
    const FrictionFit many = fitWith(threads);
    EXPECT_EQ(many.theta, one.theta) << threads;
    EXPECT_EQ(many.mse, one.mse) << threads;
    EXPECT_EQ(many.mse_heldout, one.mse_heldout) << threads;
    EXPECT_EQ(many.profile.cost, one.profile.cost) << threads;
    EXPECT_EQ(many.uncertainty.n_effective, one.uncertainty.n_effective) << threads;
    EXPECT_TRUE(many.uncertainty.covariance == one.uncertainty.covariance) << threads;
    ASSERT_EQ(many.minima.size(), one.minima.size()) << threads;
    for (std::size_t m = 0; m < one.minima.size(); ++m) EXPECT_EQ(many.minima[m].p, one.minima[m].p) << threads;
  }
}

}  // namespace
}  // namespace simgap::test
