#include "simgap/core/rotation.h"
#include "simgap/core/joint_kind.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace simgap {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond randomRotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Quaterniond{normal(random), normal(random), normal(random), normal(random)}.normalized();
}

Vector3d randomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vector3d{normal(random), normal(random), normal(random)}.normalized();
}

Quaterniond negated(const Quaterniond& q) { return Quaterniond(-q.w(), -q.x(), -q.y(), -q.z()); }

// A product of unit quaternions is off by a few 1e-16, which is all that separates a small angle from its exact value.
constexpr double kRoundedTurn = 2e-15;

TEST(GeodesicAngle, IsTheWholeAngleBetweenTwoRotations) {
  const Quaterniond quarter_turn(AngleAxisd(kDegree * 90.0, Vector3d::UnitX()));
  EXPECT_NEAR(geodesicAngle(Quaterniond::Identity(), quarter_turn), kDegree * 90.0, kRoundedTurn);
  EXPECT_NEAR(geodesicAngle(quarter_turn, quarter_turn * quarter_turn), kDegree * 90.0, kRoundedTurn);
}

TEST(GeodesicAngle, RecoversEveryAngleFromTheSmallestToHalfATurn) {
  std::mt19937 random(1);
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0, kDegree * 180.0 - 1e-9, kDegree * 180.0}) {
    for (int i = 0; i < 100; ++i) {
      const Quaterniond a = randomRotation(random);
      const Quaterniond b = a * Quaterniond(AngleAxisd(angle, randomDirection(random)));
      EXPECT_NEAR(geodesicAngle(a, b), angle, kRoundedTurn) << "angle " << angle;
    }
  }
}

TEST(GeodesicAngle, IsBlindToSignAndOrder) {
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const Quaterniond a = randomRotation(random);
    const Quaterniond b = randomRotation(random);
    EXPECT_EQ(geodesicAngle(a, b), geodesicAngle(negated(a), b));
    EXPECT_EQ(geodesicAngle(a, b), geodesicAngle(a, negated(b)));
    EXPECT_NEAR(geodesicAngle(a, b), geodesicAngle(b, a), kRoundedTurn);
    EXPECT_EQ(geodesicAngle(a, negated(a)), geodesicAngle(a, a));
  }
}

TEST(JointError, IsTheAngleOfARotationOrTheDifferenceOfAngles) {
  const JointPosition a{Quaterniond::Identity(), 0.5};
  const JointPosition b{Quaterniond(AngleAxisd(0.25, Vector3d::UnitZ())), 0.125};
  EXPECT_NEAR(jointError(JointType::kSpherical, a, b), 0.25, kRoundedTurn);
  EXPECT_EQ(jointError(JointType::kRevolute, a, b), 0.375);
  EXPECT_EQ(jointError(JointType::kRevolute, b, a), 0.375);
}

TEST(MeanRotation, OfOneRotationIsThatRotationWithPositiveW) {
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const std::vector<Quaterniond> one = {randomRotation(random)};
    const Quaterniond mean = meanRotation(one);
    EXPECT_NEAR(geodesicAngle(mean, one[0]), 0.0, 1e-14);
    EXPECT_GE(mean.w(), 0.0);
    EXPECT_NEAR(mean.norm(), 1.0, 1e-15);
  }
}

TEST(MeanRotation, OfTwoRotationsIsHalfWay) {
  const std::vector<Quaterniond> two = {Quaterniond(AngleAxisd(0.2, Vector3d::UnitY())),
                                        Quaterniond(AngleAxisd(0.8, Vector3d::UnitY()))};
  EXPECT_NEAR(geodesicAngle(meanRotation(two), Quaterniond(AngleAxisd(0.5, Vector3d::UnitY()))), 0.0, 1e-14);
}

TEST(MeanRotation, DoesNotCareAboutTheSignsOfItsQuaternions) {
  std::mt19937 random(4);
  std::vector<Quaterniond> rotations;
  for (int i = 0; i < 9; ++i) rotations.push_back(randomRotation(random));
  const Quaterniond mean = meanRotation(rotations);
  for (std::size_t i = 0; i < rotations.size(); i += 2) rotations[i] = negated(rotations[i]);
  EXPECT_EQ(meanRotation(rotations).coeffs(), mean.coeffs());
}

TEST(MeanRotation, OfSmallPerturbationsIsTheCentreAndTheirMean) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 1e-3);
  for (int trial = 0; trial < 20; ++trial) {
    const Quaterniond centre = randomRotation(random);
    std::vector<Quaterniond> rotations;
    Vector3d mean_vector = Vector3d::Zero();
    for (int i = 0; i < 50; ++i) {
      const Vector3d vector{noise(random), noise(random), noise(random)};
      mean_vector += vector / 50.0;
      const Quaterniond perturbed = centre * Quaterniond(AngleAxisd(vector.norm(), vector.normalized()));
      rotations.push_back(i % 2 == 0 ? perturbed : negated(perturbed));
    }
    const Quaterniond expected = centre * Quaterniond(AngleAxisd(mean_vector.norm(), mean_vector.normalized()));
    // Rotations of 1e-3 rad add as vectors up to terms of third order, 1e-9 rad.
    EXPECT_LT(geodesicAngle(meanRotation(rotations), expected), 1e-8) << "trial " << trial;
  }
}

TEST(ToDegrees, UndoesTheDegree) { EXPECT_DOUBLE_EQ(toDegrees(30.0 * kDegree), 30.0); }

TEST(RotationVector, ExponentialAndLogarithmAreInverse) {
  std::mt19937 random(11);
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0, kDegree * 180.0 - 1e-9}) {
    const Vector3d w = angle * randomDirection(random);
    const Quaterniond q(expSo3(w));
    EXPECT_LT(quaternionExpSo3(w).angularDistance(q), kRoundedTurn) << "angle " << angle;
    EXPECT_LT((logSo3(q) - w).norm(), kRoundedTurn) << "angle " << angle;
    EXPECT_LT((logSo3(negated(q)) - w).norm(), kRoundedTurn) << "angle " << angle;
    EXPECT_LT((expSo3(w).toRotationMatrix() - q.toRotationMatrix()).norm(), kRoundedTurn) << "angle " << angle;
  }
  EXPECT_LT((expSo3({0.0, 0.0, kDegree * 90.0}) * Vector3d::UnitX() - Vector3d::UnitY()).norm(), kRoundedTurn);
}

// Central differences of step h err by h^2 / 6 of third derivatives, about 1 here, and by rounding over h.
TEST(RotationVector, JacobiansAreTheDerivatives) {
  constexpr double kStep = 1e-5, kTolerance = 1e-9;
  std::mt19937 random(12);
  for (const double angle : {0.0, 1e-6, 9e-5, 2e-4, 0.1, 1.0, 2.5}) {
    const Vector3d w = angle * randomDirection(random);
    const Quaterniond back = Quaterniond(expSo3(w)).conjugate();
    for (int i = 0; i < 3; ++i) {
      const Vector3d h = kStep * Vector3d::Unit(i);
      const Vector3d slope = (logSo3(back * expSo3(w + h)) - logSo3(back * expSo3(w - h))) / (2.0 * kStep);
      EXPECT_LT((rightJacobian(w).col(i) - slope).norm(), kTolerance) << "angle " << angle;
    }
    EXPECT_LT((rightJacobian(w) * inverseRightJacobian(w) - Eigen::Matrix3d::Identity()).norm(), 1e-7)
        << "angle " << angle;
  }
}

TEST(RotationBetween, TakesOneDirectionToTheOtherTheShortestWay) {
  std::mt19937 random(13);
  for (int i = 0; i < 20; ++i) {
    const Vector3d from = randomDirection(random);
    for (const Vector3d& to : {randomDirection(random), from, Vector3d(-from)}) {
      const Quaterniond turn = rotationBetween(from, to);
      EXPECT_NEAR(turn.norm(), 1.0, kRoundedTurn);
      EXPECT_LT((turn * from - to).norm(), kRoundedTurn);
      EXPECT_NEAR(logSo3(turn).norm(), std::atan2(from.cross(to).norm(), from.dot(to)), kRoundedTurn);
    }
  }
}

TEST(RotationVector, CrossIsTheMatrixOfTheProduct) {
  const Vector3d a(0.3, -2.0, 1.1), b(-0.7, 0.2, 5.0);
  EXPECT_LT((cross(a) * b - a.cross(b)).norm(), kRoundedTurn * a.norm() * b.norm());
}

}  // namespace
}  // namespace simgap
