// The judge is judged first: cases that can be solved on paper, and derivatives against another difference scheme.
#include "reality/arm_statics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "reality/arm_placement.h"
#include "reality/taut_string.h"

namespace simgap::reality {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;

Part pointMass(double mass, const Vector3d& position) { return {0.01, 0.01, mass, position, Vector3d::UnitZ()}; }

// A hinge about x at the origin, 2 kg at 0.15 m below it.
Arm pendulum(Joint joint = Joint::kRevolute) {
  Arm arm;
  arm.links.resize(1);
  arm.links[0].joint = joint;
  arm.links[0].parts = {pointMass(2.0, {0, 0, -0.15})};
  return arm;
}

// A muscle whose line and cord are together as short as 10 rad of its shaft: there the cord pulls with k L.
Muscle springOfNoLength(const Vector3d& on_torso, const Vector3d& on_link, double stiffness) {
  Muscle muscle;
  muscle.from = {kTorso, on_torso};
  muscle.to = {0, on_link};
  muscle.kite_line = 0.02;
  muscle.cord_rest = 0.06;
  muscle.spindle_radius = 0.008;
  muscle.stiffness = stiffness;
  return muscle;
}

// The same joint moved by a rotation vector (or an angle, its first component).
Configuration displaced(const Arm& arm, Configuration q, std::size_t link, const Vector3d& w) {
  if (arm.links[link].joint == Joint::kRevolute) {
    q[link].angle += w.x();
  } else if (w.norm() > 0.0) {
    q[link].rotation *= Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  }
  return q;
}

Configuration somePose(const Arm& arm, double size) {
  Configuration q = restPose(arm);
  for (std::size_t i = 0; i < q.size(); ++i)
    q = displaced(arm, q, i, size * Vector3d(0.5, -0.4 + 0.1 * double(i), 0.3));
  return q;
}

TEST(ArmStatics, AMuscleThatBendsRoundAJointIsATautString) {
  for (const Joint joint : {Joint::kSpherical, Joint::kRevolute}) {
    Arm arm = pendulum(joint);
    Muscle& muscle = arm.muscles.emplace_back();
    muscle.from = {kTorso, {0.01, 0.03, 0.07}};
    muscle.to = {0, {-0.03, 0.02, -0.09}};
    muscle.wrap_link = 0;
    muscle.wrap_radius = 0.05;
    const Vector3d along = joint == Joint::kRevolute ? arm.links[0].axis : Vector3d::Zero();
    const auto fromMiddle = [&](const Vector3d& x) { return Vector3d(x - x.dot(along) * along); };
    for (const double size : {0.0, 0.4, -0.3}) {
      const Configuration q = somePose(arm, size);
      const Placement<double> placement(arm, q, Displacement<double>::Zero(freedoms(arm)));
      const Vector3d from = placement.at(muscle.from), to = placement.at(muscle.to);
      const double string = tautString(from, to, {0.0, 0.08, 0.0}, muscle.wrap_radius, fromMiddle);
      EXPECT_GT(string, (to - from).norm() + 1e-4) << "it has to bend";
      EXPECT_NEAR(lineLength<double>(muscle, arm, placement), string, 2e-6);
    }
  }
}

TEST(ArmStatics, PendulumWithOneMuscleRestsWhereThePaperSays) {
  // Attached at a on +y and b down the link, L^2 = a^2 + b^2 - 2ab sin(theta), so that
  // E = -m g l cos(theta) - k a b sin(theta) + constant: tan(theta) = k a b / (m g l), curvature = the hypotenuse.
  const double a = 0.05;
  const double b = 0.12;
  const double k = 700.0;
  Arm arm = pendulum();
  arm.muscles = {springOfNoLength({0, a, 0}, {0, 0, -b}, k)};
  const double weight = 2.0 * kGravity * 0.15;
  const std::vector<double> shafts{10.0};
  const Equilibrium found = followFromRest(arm, shafts);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.configuration[0].angle, std::atan2(k * a * b, weight), 1e-10);
  EXPECT_NEAR(found.stiffness, std::hypot(k * a * b, weight), 1e-6);
}

TEST(ArmStatics, WindingUpByARadianShortensTheLineByTheSpindleRadius) {
  Arm arm = pendulum();
  arm.muscles = {springOfNoLength({0, 0.03, 0}, {0, 0, -0.04}, 1000.0)};
  // Hanging straight: L = 0.05 (3-4-5), expansion 0.05 - 0.02 - 0.06 + 0.008 phi, lever arm 0.03 * 4/5 = 0.024.
  const Configuration straight(1);
  const auto torque = [&](double shaft) { return jointTorque(arm, std::vector<double>{shaft}, straight)[0][0]; };
  EXPECT_EQ(torque(3.0), 0.0) << "the cord is slack by 6 mm";
  EXPECT_NEAR(torque(5.0), 0.024 * 10.0, 1e-12);
  EXPECT_NEAR(torque(6.0) - torque(5.0), 0.024 * 8.0, 1e-12);
  EXPECT_NEAR(totalEnergy(arm, std::vector<double>{5.0}, straight), -2.0 * kGravity * 0.15 + 500.0 * 1e-4, 1e-12);
}

TEST(ArmStatics, SphericalPendulumPointsAlongTheSumOfWeightAndPull) {
  // With a spring of no length E = -(k b a + m l g) . u, u the direction of the link: u along that sum, spin neutral.
  Arm arm = pendulum(Joint::kSpherical);
  const Vector3d a(0.04, -0.06, 0.01);
  arm.muscles = {springOfNoLength(a, {0, 0, -0.12}, 700.0)};
  const Equilibrium found = followFromRest(arm, std::vector<double>{10.0});
  EXPECT_TRUE(found.converged);
  const Vector3d direction = -found.configuration[0].rotation.col(2);
  const Vector3d expected = (700.0 * 0.12 * a + 2.0 * 0.15 * Vector3d(0, 0, -kGravity)).normalized();
  EXPECT_LT((direction - expected).norm(), 1e-10) << direction.transpose() << " for " << expected.transpose();
  EXPECT_NEAR(found.stiffness, 0.0, 1e-6);
}

TEST(ArmStatics, SphericalTorqueIsGivenInTheChildsFrame) {
  // Turned by 90 deg about z, then tilted by 30 deg about the child's x: gravity turns it back about the child's x.
  const Arm arm = pendulum(Joint::kSpherical);
  Configuration q(1);
  q[0].rotation = (Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ()) * Eigen::AngleAxisd(M_PI / 6, Vector3d::UnitX()))
                      .toRotationMatrix();
  const Eigen::VectorXd torque = jointTorque(arm, {}, q)[0];
  EXPECT_LT((torque - Vector3d(-2.0 * kGravity * 0.15 * 0.5, 0, 0)).norm(), 1e-12) << torque.transpose();
}

TEST(ArmStatics, WithoutMusclesEveryArmHangsStraightDown) {
  Arm arm = pendulum(Joint::kSpherical);
  arm.links.push_back(arm.links[0]);
  arm.links[1].parent = 0;
  arm.links[1].joint_in_parent = {0, 0, -0.3};
  arm.links.push_back(pendulum().links[0]);
  arm.links[2].parent = 1;
  arm.links[2].joint_in_parent = {0, 0, -0.3};
  const Equilibrium found = minimise(arm, {}, somePose(arm, 1.5));
  EXPECT_TRUE(found.converged) << found.gradient_norm;
  const Eigen::Matrix3d first = found.configuration[0].rotation;
  const Eigen::Matrix3d second = first * found.configuration[1].rotation;
  EXPECT_LT((first.col(2) - Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_LT((second.col(2) - Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(found.configuration[2].angle, 0.0, 1e-9);
  EXPECT_NEAR(totalEnergy(arm, {}, found.configuration), -2.0 * kGravity * (0.15 + 0.45 + 0.75), 1e-12);
}

TEST(ArmStatics, JointPositionInTheChildShiftsTheChild) {
  // The joint sits 0.1 m above the child's origin and 0.02 m beside it: the mass hangs below the joint, not the origin.
  Arm arm = pendulum();
  arm.links[0].joint_in_child = {0, 0.02, 0.1};
  const Equilibrium found = minimise(arm, {}, restPose(arm));
  EXPECT_NEAR(found.configuration[0].angle, std::atan2(0.02, 0.25), 1e-10);
}

TEST(ArmStatics, AJointRestsOnItsStop) {
  Arm arm = pendulum();
  arm.links[0].lower = 0.5;
  arm.links[0].upper = 1.0;
  const Equilibrium low = followFromRest(arm, {});
  EXPECT_EQ(low.configuration[0].angle, 0.5);
  EXPECT_TRUE(low.converged && low.at_stop[0]);
  EXPECT_EQ(low.residual[0][0], 0.0);
  EXPECT_TRUE(std::isinf(low.stiffness));
  EXPECT_NEAR(jointTorque(arm, {}, low.configuration)[0][0], -2.0 * kGravity * 0.15 * std::sin(0.5), 1e-12);

  arm.muscles = {springOfNoLength({0, 0.05, 0}, {0, 0, -0.12}, 4000.0)};  // atan(24 / 2.94) is past the upper stop
  const Equilibrium high = followFromRest(arm, std::vector<double>{10.0});
  EXPECT_EQ(high.configuration[0].angle, 1.0);
  EXPECT_TRUE(high.converged && high.at_stop[0]);
}

TEST(ArmStatics, AStopDoesNotHoldTheOtherJoints) {
  Arm arm = pendulum();
  arm.links[0].lower = 0.5;
  arm.links[0].upper = 1.0;
  arm.links.push_back(pendulum().links[0]);
  arm.links[1].parent = 0;
  arm.links[1].joint_in_parent = {0, 0, -0.3};
  const Equilibrium found = followFromRest(arm, {});
  EXPECT_TRUE(found.at_stop[0] && !found.at_stop[1]);
  EXPECT_NEAR(found.configuration[1].angle, -0.5, 1e-10) << "the second link hangs down";
  EXPECT_NEAR(found.stiffness, 2.0 * kGravity * 0.15, 1e-6);
}

TEST(ArmStatics, AJointDraggedAgainstItsStopDoesNotHaltTheOthers) {
  // At the start the second link's weight turns joint 1 off its stop (1.47 - 1.17 = 0.30 N m), but Newton's step of
  // both joints would drag it through: the stop must hold it while joint 2 goes on.
  Arm arm = pendulum();
  arm.links[0].lower = 0.1334;
  arm.links[0].upper = 1.0;
  arm.links.push_back(pendulum().links[0]);
  arm.links[1].parent = 0;
  arm.links[1].joint_in_parent = {0, 0, -0.3};
  Configuration start(2);
  start[0].angle = 0.1334;
  start[1].angle = -0.657;
  ASSERT_NEAR(jointTorque(arm, {}, start)[0][0], 0.30, 0.01) << "away from the stop";
  const Equilibrium found = minimise(arm, {}, start);
  EXPECT_TRUE(found.converged && found.at_stop[0]) << found.gradient_norm;
  EXPECT_NEAR(found.configuration[1].angle, -0.1334, 1e-10);
}

TEST(ArmStatics, TorqueAgreesWithRealDifferencesOfTheEnergy) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Arm arm = seed == 0 ? referenceArm() : randomArm(seed);
    const std::vector<double> shafts(arm.muscles.size(), 1.0);
    const Configuration q = somePose(arm, 0.6);
    const JointTorques torque = jointTorque(arm, shafts, q);
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      for (int c = 0; c < torque[i].size(); ++c) {
        const auto at = [&](double h) { return totalEnergy(arm, shafts, displaced(arm, q, i, h * Vector3d::Unit(c))); };
        const double h = 3e-4;  // fourth order: truncation h^4, rounding 1e-15 / h
        const double slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        EXPECT_NEAR(torque[i][c], -slope, 1e-9) << "seed " << seed << ", link " << i << ", component " << c;
      }
    }
  }
}

TEST(ArmStatics, EnergyFallsToAMinimum) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Arm arm = randomArm(seed);
    const std::vector<double> shafts = randomShafts(arm, seed + 100);
    const Configuration start = somePose(arm, 0.5);
    const Equilibrium found = minimise(arm, shafts, start);
    ASSERT_TRUE(found.converged) << "seed " << seed << ": " << found.gradient_norm << " N m";
    const double lowest = totalEnergy(arm, shafts, found.configuration);
    EXPECT_LE(lowest, totalEnergy(arm, shafts, start));
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      if (found.at_stop[i]) continue;
      for (int c = 0; c < found.residual[i].size(); ++c) {
        for (const double h : {-1e-3, 1e-3}) {
          const Configuration beside = displaced(arm, found.configuration, i, h * Vector3d::Unit(c));
          EXPECT_GT(totalEnergy(arm, shafts, beside), lowest) << "seed " << seed << ", link " << i;
        }
      }
    }
  }
}

TEST(ArmStatics, StartingFromItsOwnAnswerStaysThere) {
  const Arm arm = referenceArm();
  const std::vector<double> shafts = randomShafts(arm, 7);
  const Equilibrium followed = followFromRest(arm, shafts);
  ASSERT_TRUE(followed.converged);
  const Equilibrium again = minimise(arm, shafts, displaced(arm, followed.configuration, 0, {0.02, -0.03, 0.02}));
  const Eigen::Matrix3d apart = followed.configuration[0].rotation.transpose() * again.configuration[0].rotation;
  EXPECT_LT((apart - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  EXPECT_NEAR(again.configuration[1].angle, followed.configuration[1].angle, 1e-9);
}

TEST(ArmStatics, RandomArmsAreStableVariedAndRepeatable) {
  int spherical = 0;
  int revolute = 0;
  int branched = 0;
  int biarticular = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Arm arm = randomArm(seed);
    EXPECT_EQ(toYaml(arm), toYaml(randomArm(seed)));
    EXPECT_GE(arm.muscles.size(), 4u);
    EXPECT_LE(arm.muscles.size(), 14u);
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      ++(arm.links[i].joint == Joint::kSpherical ? spherical : revolute);
      branched += arm.links[i].parent != int(i) - 1;
      ASSERT_LT(arm.links[i].parent, int(i));
    }
    for (const Muscle& muscle : arm.muscles) {
      biarticular += arm.links[std::size_t(muscle.to.link)].parent != muscle.from.link;
    }
    const std::vector<double> shafts = randomShafts(arm, seed);
    const Equilibrium pose = followFromRest(arm, shafts);
    EXPECT_TRUE(pose.converged && pose.stiffness > 0.3) << "seed " << seed << ": " << pose.stiffness << " N m/rad";
    EXPECT_GT(std::abs(*std::max_element(shafts.begin(), shafts.end())), 0.5);
  }
  EXPECT_TRUE(spherical > 5 && revolute > 5 && branched > 2 && biarticular > 2)
      << spherical << " " << revolute << " " << branched << " " << biarticular;
}

TEST(ArmStatics, TheModelFileSaysWhatTheArmIs) {
  Arm arm = referenceArm();
  arm.links[1].upper = std::numeric_limits<double>::infinity();
  const std::string text = toYaml(arm);
  for (const char* part : {"format: simgap/arm/1", "{name: torso, fixed: true}", "name: joint2, type: revolute",
                           "parent: link1, child: link2", "lower_limit_rad: 0,", "name: muscle11", "ratio: 72"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(text.find("upper_limit_rad"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
  EXPECT_EQ(toYaml(arm, {.coulomb = false}).find("coulomb_friction_Nm: 0.05"), std::string::npos);
}

}  // namespace
}  // namespace simgap::reality
