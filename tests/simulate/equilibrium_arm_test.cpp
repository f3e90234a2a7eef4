// Equilibria found by Newton's method against the independent minimiser, and what must hold of any of them.
#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "reality/arm_statics.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "support/arms.h"
#include "support/statics.h"

namespace simgap {
namespace {

reality::Arm arm(std::uint64_t seed) { return seed == 0 ? reality::referenceArm() : reality::randomArm(seed); }

// Follows the shafts from rest, as the judge does with other means.
void compareWithFollowing(std::uint64_t first, std::uint64_t last, int poses, const char* name) {
  int all = 0, stable = 0, elsewhere = 0, iterations = 0;
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const reality::Arm real = arm(seed);
    const ArmModel model = test::modelOf(real, false);
    EquilibriumArm equilibrium(model);
    for (int pose = 0; pose < poses; ++pose) {
      const std::vector<double> shafts = reality::randomShafts(real, 1000 * seed + static_cast<std::uint64_t>(pose));
      const EquilibriumSolution solution = equilibrium.solve(shafts);
      ++all;
      stable += solution.stable;
      iterations += solution.iterations;
      const reality::Equilibrium followed = reality::followFromRest(real, shafts);
      const reality::Configuration found = test::configurationOf(real, equilibrium.joints());
      const bool same = toDegrees(test::largestAngle(real, found, followed.configuration)) < 0.01;
      elsewhere += !same;
      if (!same)
        std::cout << "arm " << seed << ", pose " << pose << ": another branch, stable " << solution.stable << "\n";
      // Wherever it is, it is a minimum for the judge as well.
      const reality::Equilibrium near = reality::minimise(real, shafts, found);
      EXPECT_LT(test::largestAngle(real, found, near.configuration), 1e-6) << "arm " << seed << ", pose " << pose;
    }
  }
  std::cout << name << ": " << stable << " of " << all << " stable, " << elsewhere << " on another branch, "
            << static_cast<double>(iterations) / all << " evaluations per pose\n";
  EXPECT_EQ(stable, all);
  EXPECT_LE(elsewhere, 0.003 * all);
}

TEST(EquilibriumArm, RestsWhereTheIndependentMinimiserFollowsTheShafts) {
  compareWithFollowing(0, 60, 4, "equilibria");
}
TEST(SlowEquilibriumArm, RestsWhereTheIndependentMinimiserFollowsTheShafts) {
  compareWithFollowing(61, 500, 10, "equilibria of 440 arms");
}

TEST(EquilibriumArm, SensitivitiesAgreeWithDifferencesOfEquilibria) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const reality::Arm real = arm(seed);
    ArmModel model = test::modelOf(real, false);
    const std::vector<double> shafts = reality::randomShafts(real, seed);
    std::vector<std::string> names;
    std::vector<double> values;
    visitParameters(model, [&](const ParameterPath& path, const ParameterKind&, double& value) {
      names.push_back(path.str());
      values.push_back(value);
    });
    EquilibriumArm equilibrium(model);
    ASSERT_TRUE(equilibrium.solve(shafts).stable);
    equilibrium.linearise();
    const std::vector<JointPosition> solution = equilibrium.joints();
    Eigen::MatrixXd columns(equilibrium.energy().degreesOfFreedom(), names.size());
    equilibrium.sensitivities(staticParameters(model, names), columns);
    for (std::size_t p = 0; p < names.size(); ++p) {
      // A cord of k = 900 N/m that changes by 1e-5 m stays on its side of the kink, if it is not within that of it.
      const double h = 1e-5 * std::max(0.01, std::abs(values[p]));
      const auto solveAt = [&](double value) {
        ArmModel changed = model;
        std::size_t k = 0;
        visitParameters(changed, [&](const ParameterPath&, const ParameterKind&, double& number) {
          if (k++ == p) number = value;
        });
        EquilibriumArm other(changed);
        EXPECT_TRUE(other.solveFrom(solution, shafts).stable);
        other.linearise();  // one more Newton step's worth of accuracy is there already; this only evaluates
        return other.joints();
      };
      const auto plus = solveAt(values[p] + h);
      const auto minus = solveAt(values[p] - h);
      for (std::size_t j = 0; j < model.joints.size(); ++j) {
        const int d = equilibrium.energy().firstDof(static_cast<int>(j));
        Eigen::VectorXd slope(model.joints[j].degreesOfFreedom());
        if (model.joints[j].type == JointType::kSpherical) {
          const Eigen::AngleAxisd turn(minus[j].rotation.conjugate() * plus[j].rotation);
          slope = turn.angle() * turn.axis() / (2.0 * h);
        } else {
          slope[0] = (plus[j].angle - minus[j].angle) / (2.0 * h);
        }
        const Eigen::VectorXd found = columns.col(p).segment(d, slope.size());
        EXPECT_LT((found - slope).norm(), 1e-5 * std::max(1.0, slope.norm()))
            << "arm " << seed << ", " << names[p] << ": " << found.transpose() << " for " << slope.transpose();
      }
    }
  }
}

TEST(EquilibriumArm, TurnsWithTheWorld) {
  // Gravity, the torso's attachments and the joint on it turned by Q: the shoulder turns by Q, the elbow does not move.
  const reality::Arm real = reality::referenceArm();
  const ArmModel model = test::modelOf(real, false);
  std::mt19937 random(5);
  for (int pose = 0; pose < 10; ++pose) {
    const std::vector<double> shafts = reality::randomShafts(real, static_cast<std::uint64_t>(pose));
    const Eigen::Quaterniond turn = test::randomRotation(random);
    ArmModel turned = model;
    turned.gravity = turn * model.gravity;
    for (Muscle& muscle : turned.muscles) {
      for (Attachment& end : muscle.attachments) {
        if (model.bodies[end.body].fixed) end.point = turn * end.point;
      }
    }
    EquilibriumArm a(model), b(turned);
    ASSERT_TRUE(a.solve(shafts).stable);
    std::vector<JointPosition> start = a.joints();
    start[0].rotation = turn * Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())) * start[0].rotation;
    ASSERT_TRUE(b.solveFrom(start, shafts).stable);
    EXPECT_LT(geodesicAngle(turn * a.joints()[0].rotation, b.joints()[0].rotation), 1e-8);
    EXPECT_NEAR(a.joints()[1].angle, b.joints()[1].angle, 1e-8);
  }
}

TEST(EquilibriumArm, StopsHoldAJointAndLeaveTheOthersFree) {
  ArmModel model = test::torso();
  Joint& upper = test::addLink(model, 0, JointType::kRevolute, {0, 0, 0}, {test::sphere(2.0, {0, 0, -0.15})});
  upper.lower_limit = 0.1334;
  upper.upper_limit = 1.0;
  test::addLink(model, 1, JointType::kRevolute, {0, 0, -0.3}, {test::sphere(2.0, {0, 0, -0.15})});
  EquilibriumArm equilibrium(model);
  const EquilibriumSolution solution =
      equilibrium.solveFrom(std::vector<JointPosition>{test::hingeAt(0.1334), test::hingeAt(-0.657)}, {});
  EXPECT_TRUE(solution.stable);
  EXPECT_TRUE(equilibrium.atStop(0));
  EXPECT_FALSE(equilibrium.atStop(1));
  EXPECT_EQ(equilibrium.joints()[0].angle, 0.1334);
  EXPECT_NEAR(equilibrium.joints()[1].angle, -0.1334, 1e-9);
}

TEST(EquilibriumArm, AnUprightPendulumIsNoStableEquilibrium) {
  const ArmModel model = test::pendulum(JointType::kSpherical);
  EquilibriumArm equilibrium(model);
  // A ball joint turns freely about the vertical even when it hangs: no unique pose.
  EXPECT_FALSE(equilibrium.solveFrom(std::vector<JointPosition>{test::ballAt(0.4, {1, 0, 0})}, {}).stable);
  // Exactly upright a hinge feels no torque, and is not at rest for that.
  EquilibriumArm hinge(test::pendulum());
  const EquilibriumSolution upright = hinge.solveFrom(std::vector<JointPosition>{test::hingeAt(M_PI)}, {});
  EXPECT_TRUE(!upright.stable || std::abs(hinge.joints()[0].angle) < 1.0) << hinge.joints()[0].angle;
}

TEST(EquilibriumArm, FindsBothEquilibriaOfAHingeBetweenTwoOfThem) {
  // A strong cord of no length fixed straight above the hinge makes the top stable too? It pulls up against gravity:
  // with k a b > m g l the top is the only minimum; a second cord of finite length below makes two.
  ArmModel model = test::pendulum();
  test::addMuscle(model, {0, {0, 0, 0.2}}, {1, {0, 0, -0.1}}, 0.2);
  model.joints[0].upper_limit = 3.0;
  model.joints[0].lower_limit = -3.0;
  EquilibriumArm equilibrium(model);
  const std::vector<double> shafts{0.0};
  ASSERT_TRUE(equilibrium.solveFrom(std::vector<JointPosition>{test::hingeAt(0.5)}, shafts).stable);
  const std::vector<JointPosition> first = equilibrium.joints();
  ASSERT_GT(std::abs(first[0].angle), 0.1) << "symmetric: the other side is an equilibrium as well";
  const auto all = distinctEquilibria(equilibrium, shafts, first);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_NEAR(all[1][0].angle, -first[0].angle, 1e-6);
}

TEST(EquilibriumArm, GivesUpOnShaftsThatNoArmFollows) {
  // Far beyond what its lines can hold: whatever comes out, it comes soon.
  const reality::Arm real = reality::referenceArm();
  EquilibriumArm equilibrium(test::modelOf(real, false));
  for (const double shaft : {4000.0, -4000.0, 4e6, -4e6}) {
    const std::vector<double> shafts(real.muscles.size(), shaft);
    EXPECT_LE(equilibrium.solve(shafts).iterations, 4300) << shaft;
  }
}

TEST(EquilibriumArm, FindsItsWayDownWhereTheEnergyIsNotConvex) {
  // Starts turned far away, where most of the ways down begin on a ridge.
  constexpr int kStarts = 400;
  const reality::Arm real = reality::referenceArm();
  EquilibriumArm equilibrium(test::modelOf(real, false));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> bend(0.0, 2.0);
  int found = 0, evaluations = 0;
  for (int start = 0; start < kStarts; ++start) {
    const std::vector<double> shafts = reality::randomShafts(real, static_cast<std::uint64_t>(start % 20));
    std::vector<JointPosition> from = equilibrium.joints();
    from[0].rotation = test::randomRotation(random);
    from[1].angle = bend(random);
    const EquilibriumSolution solution = equilibrium.solveFrom(from, shafts);
    found += solution.stable;
    evaluations += solution.iterations;
  }
  std::cout << found << " of " << kStarts << " found, " << static_cast<double>(evaluations) / kStarts
            << " evaluations each\n";
  EXPECT_EQ(found, kStarts);
}

TEST(EquilibriumArm, EnergyNeverRisesOverNewtonSteps) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const reality::Arm real = arm(seed);
    EquilibriumArm equilibrium(test::modelOf(real, false));
    const std::vector<double> shafts = reality::randomShafts(real, seed);
    std::vector<JointPosition> position = equilibrium.joints();  // the start
    double energy = reality::totalEnergy(real, shafts, test::configurationOf(real, position));
    for (int steps = 1; steps < 30; ++steps) {
      equilibrium.solveFrom(position, shafts, steps);
      const double now = reality::totalEnergy(real, shafts, test::configurationOf(real, equilibrium.joints()));
      EXPECT_LE(now, energy + 1e-12) << "arm " << seed << ", step " << steps;
      energy = now;
    }
  }
}

}  // namespace
}  // namespace simgap
