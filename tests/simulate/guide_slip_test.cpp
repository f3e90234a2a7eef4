// Friction of guides within a step: the impulses and slips that balance, found without memory of their own.
#include "simulate/guide_slip.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/random.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/simulate/bullet_arm.h"
#include "simulate/allocation_counter.h"
#include "support/arms.h"

namespace simgap {
namespace {

constexpr Eigen::Index kTurns = 4;  // degrees of freedom
constexpr int kGuides = 11;
constexpr Eigen::Index kOneTurn = 1;
constexpr int kTwoGuides = 2;

/// Joints and lines of the size of an arm's: moments of inertia, lever arms, tensions of some 10 N over steps of 2 ms.
struct DrawnStep {
  Eigen::MatrixXd inertia;
  Eigen::VectorXd free;
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> most;
  double creep;

  explicit DrawnStep(std::uint64_t seed, Eigen::Index turns = kTurns, int guides = kGuides) {
    const CounterRandom random(seed);
    std::uint32_t next = 0;
    const auto normal = [&] { return random.normalPair({next++, 0, 0, 71})[0]; };
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(turns, turns, normal);
    inertia = 0.02 * (root * root.transpose() + 0.1 * Eigen::MatrixXd::Identity(turns, turns));
    const double speed = std::pow(10.0, -3.0 + 4.0 * random.uniform({0, 0, 0, 72}));
    free = speed * Eigen::VectorXd::NullaryExpr(turns, normal);
    for (int i = 0; i < guides; ++i) {
      rows.emplace_back(0.03 * Eigen::VectorXd::NullaryExpr(turns, normal));
      most.push_back(0.002 * 0.15 * 60.0 * std::abs(normal()));
    }
    creep = seed % 2 == 0 ? 1e-3 : 1e-5;
  }
  void giveTo(GuideSlip& guides) const {
    guides.clear();
    for (std::size_t i = 0; i < rows.size(); ++i) guides.add(rows[i], most[i], creep);
  }
  double impulse(std::size_t i, const Eigen::VectorXd& v) const {
    const double slip = rows[i].dot(v);
    return most[i] * slip / std::hypot(slip, creep);
  }
  /// One guide after the other, each to its own balance, until nothing changes.
  Eigen::VectorXd oneByOne() const {
    const Eigen::MatrixXd mobility = inertia.inverse();
    Eigen::VectorXd v = free;
    std::vector<double> given(rows.size(), 0.0);
    for (double changed = 1.0; changed > 1e-14;) {
      changed = 0.0;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        const Eigen::VectorXd response = mobility * rows[i];
        const double give = rows[i].dot(response), alone = rows[i].dot(v) + give * given[i];
        double low = -most[i], high = most[i];  // of its impulse
        while (high - low > 1e-17) {
          const double middle = 0.5 * (low + high), slip = alone - give * middle;
          (middle < most[i] * slip / std::hypot(slip, creep) ? low : high) = middle;
          if (middle == 0.5 * (low + high)) break;
        }
        v -= (high - given[i]) * response;
        changed = std::max(changed, std::abs(high - given[i]) * give);
        given[i] = high;
      }
    }
    return v;
  }
};

TEST(GuideSlip, ImpulsesBalanceTheChangeOfMomentum) {
  GuideSlip guides(kTurns, kGuides);
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const DrawnStep step(seed);
    step.giveTo(guides);
    Eigen::VectorXd v = step.free;
    const int steps = guides.solve(step.inertia, seed % 3 == 0 ? Eigen::VectorXd::Zero(kTurns) : step.free, v);
    EXPECT_LE(steps, 25) << seed;
    Eigen::VectorXd left = step.inertia * (v - step.free);
    double size = 0.0;
    for (std::size_t i = 0; i < step.rows.size(); ++i) {
      left += step.impulse(i, v) * step.rows[i];
      size += step.most[i] * step.rows[i].norm();
    }
    // The last step is below 1e-8 m/s, a thousandth of the smaller creep: what it leaves is of second order in that.
    EXPECT_LT(left.norm(), 1e-6 * size) << seed;
  }
}

TEST(GuideSlip, IsWhatGuidesOneAfterTheOtherComeTo) {
  GuideSlip guides(kTurns, kGuides);
  for (std::uint64_t seed = 0; seed < 40; seed += 2) {
    const DrawnStep step(seed);
    step.giveTo(guides);
    Eigen::VectorXd v = step.free;
    guides.solve(step.inertia, step.free, v);
    const Eigen::VectorXd other = step.oneByOne();
    for (const Eigen::VectorXd& row : step.rows) EXPECT_NEAR(row.dot(v), row.dot(other), 1e-8) << seed;  // [m/s]
  }
}

TEST(GuideSlip, WhereItIsSolvedAlreadyItStays) {
  GuideSlip guides(kOneTurn, kTwoGuides);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const DrawnStep step(seed, kOneTurn, kTwoGuides);
    step.giveTo(guides);
    Eigen::VectorXd v = step.free, again = step.free;
    guides.solve(step.inertia, step.free, v);
    guides.solve(step.inertia, v, again);
    EXPECT_NEAR(v[0], again[0], 1e-7) << seed;  // rounding must not make a number none
  }
}

TEST(GuideSlip, AHeavyTensionHoldsTheLine) {
  GuideSlip guides(1, 1);
  const auto left = [&](double most) {
    guides.clear();
    guides.add(Eigen::VectorXd::Constant(1, 0.03), most, 1e-3);
    Eigen::VectorXd v = Eigen::VectorXd::Constant(1, 1.0);
    guides.solve(Eigen::MatrixXd::Constant(1, 1, 0.02), Eigen::VectorXd::Zero(1), v);
    return v[0];
  };
  EXPECT_NEAR(left(0.1), 1.0 - 0.03 * 0.1 / 0.02, 2e-4);  // slips: nearly all of the most
  // Held: 0.02 of momentum takes the part 0.02 / (0.03 * 10) of the most, and a slip of creep s / sqrt(1 - s^2).
  const double part = 0.02 / 0.3, slip = 1e-3 * part / std::sqrt(1.0 - part * part);
  EXPECT_NEAR(left(10.0), slip / 0.03, 1e-5);
}

TEST(GuideSlip, ItsMobilityIsTheAnswerToAFurtherImpulse) {
  GuideSlip guides(kTurns, kGuides);
  for (std::uint64_t seed = 0; seed < 50; seed += 2) {
    const DrawnStep step(seed);
    step.giveTo(guides);
    Eigen::VectorXd v = step.free;
    guides.solve(step.inertia, step.free, v);
    const Eigen::MatrixXd mobility = guides.mobility();
    const Eigen::VectorXd impulse = step.creep * step.inertia * Eigen::VectorXd::LinSpaced(kTurns, -1.0, 1.0) * 1e-2;
    Eigen::VectorXd pushed = step.free + step.inertia.inverse() * impulse;
    guides.solve(step.inertia, v, pushed);
    EXPECT_LT((pushed - v - mobility * impulse).norm(), 0.02 * (mobility * impulse).norm()) << seed;
  }
}

/// A pendulum that a cord pulls to the side, k h l cos(a) against m g l sin(a), creeps on over its guide until what is
/// left between both is the dry friction of its joint, however slowly the guide lets it come.
TEST(GuideSlip, DryFrictionOfAJointStopsItsCreepNoSoonerThanFrictionIsLarge) {
  constexpr double kDry = 0.1, kAside = 0.02;  // [N m], [m]
  ArmModel model = test::pendulum();
  model.joints[0].coulomb_friction = kDry;
  Muscle& muscle = test::addMuscle(model, {0, {0.0, kAside, 0.0}}, {1, {0.0, 0.0, -test::kPendulumLength}}, 0.0);
  muscle.gearbox.coulomb_friction = 1e3;
  model.extensions.push_back(makeExtension(*findArmEffect("guide-friction"), "", {0.3, 1e-3}));
  const double pull = muscle.shock_cord.stiffness * kAside * test::kPendulumLength;
  for (const double step : {0.002, 0.00025}) {
    BulletArm arm(model, {.step = step});
    for (double t = 0.0; t < 40.0; t += step) arm.stepMotion();
    const double angle = arm.jointPosition(0).angle;
    const double left =
        pull * std::cos(angle) - test::kPendulumMass * test::kGravity * test::kPendulumLength * std::sin(angle);
    EXPECT_NEAR(std::abs(left), kDry, 0.03 * kDry) << step;
  }
}

TEST(GuideSlip, StepsOfAnArmWithGuidesTakeNoMemory) {
#ifdef SIMGAP_COUNTS_ALLOCATIONS
  ArmModel model = test::exampleArm();
  model.extensions.push_back(makeExtension(*findArmEffect("guide-friction"), "", {0.15, 1e-3}));
  BulletArm arm(model, {});
  for (std::size_t m = 0; m < arm.muscles(); ++m) arm.setVoltage(m, 6.0);
  for (int i = 0; i < 20; ++i) arm.stepMotion();
  const long before = test::allocations;
  for (int i = 0; i < 200; ++i) arm.stepMotion();
  EXPECT_EQ(test::allocations - before, 0);
  EXPECT_GT(arm.jointSpeed(0), 0.0);
#else
  GTEST_SKIP() << "the sanitizers have an allocator of their own";
#endif
}

}  // namespace
}  // namespace simgap
