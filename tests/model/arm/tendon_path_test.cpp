// Lengths of lines over surfaces against a taut string, and their derivatives against differences.
#include "simgap/model/arm/tendon_path.h"

#include <gtest/gtest.h>

#include <numbers>

#include "reality/taut_string.h"
#include "support/arms.h"

namespace simgap {
namespace {

struct Drawn {
  PlacedSurface surface;
  Eigen::Vector3d x0, x1;
};

Eigen::Vector3d fromMiddle(const PlacedSurface& s, const Eigen::Vector3d& x) {
  const Eigen::Vector3d way = x - s.centre;
  return s.shape == Surface::Shape::kSphere ? way : Eigen::Vector3d(way - s.axis * s.axis.dot(way));
}

/// A surface between two points whose straight line it is in the way of.
Drawn drawn(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  for (;;) {
    Drawn d{{seed % 2 ? Surface::Shape::kSphere : Surface::Shape::kCylinder, test::uniform(random, 0.02, 0.05),
             0.1 * test::randomDirection(random), test::randomDirection(random)},
            {},
            {}};
    for (Eigen::Vector3d* end : {&d.x0, &d.x1}) {
      const Eigen::Vector3d direction = test::randomDirection(random);
      *end = d.surface.centre + test::uniform(random, 0.07, 0.2) * direction;
    }
    Stretch stretch;
    wrappedStretch(d.surface, d.x0, d.x1, nullptr, stretch);
    const double deep = stretch.by_radius;
    if (stretch.wrapped && deep > 0.2) return d;
  }
}

class StretchOverSurface : public testing::TestWithParam<int> {};

TEST_P(StretchOverSurface, IsAsLongAsATautString) {
  const auto [surface, x0, x1] = drawn(GetParam());
  Stretch stretch;
  wrappedStretch(surface, x0, x1, nullptr, stretch);
  const Eigen::Vector3d middle = 0.5 * (stretch.touch[0] + stretch.touch[1]);
  const Eigen::Vector3d out = fromMiddle(surface, middle);
  const Eigen::Vector3d first = middle + (1.2 * surface.radius / out.norm() - 1.0) * out;
  const double string = reality::tautString(x0, x1, first, surface.radius,
                                            [&surface = surface](const auto& x) { return fromMiddle(surface, x); });
  // 128 points: an arc of at most 3 rad, about 20 of its points on it, is a polygon too short by 1e-3 of 1/24.
  EXPECT_NEAR(stretch.length, string, 1e-4 * stretch.length);
  EXPECT_GT(stretch.length, (x1 - x0).norm() * (1.0 + 1e-6));
  for (int a = 0; a < 2; ++a) {
    EXPECT_NEAR(fromMiddle(surface, stretch.touch[a]).norm(), surface.radius, 1e-12);
    EXPECT_NEAR(stretch.slope[a].dot(fromMiddle(surface, stretch.touch[a])), 0.0, 1e-12);
    EXPECT_NEAR(stretch.slope[a].norm(), 1.0, 1e-12);
  }
}

TEST_P(StretchOverSurface, DerivativesAgreeWithDifferences) {
  const auto [surface, x0, x1] = drawn(GetParam());
  const Eigen::Vector3d behind =
      surface.centre - 3.0 * surface.radius * fromMiddle(surface, 0.5 * (x0 + x1)).normalized();
  for (const Eigen::Vector3d* side : {static_cast<const Eigen::Vector3d*>(nullptr), &behind}) {
    Stretch stretch, up, down;
    wrappedStretch(surface, x0, x1, side, stretch);
    ASSERT_TRUE(stretch.wrapped);
    const double h = 1e-6;
    for (int a = 0; a < 2; ++a) {
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
        wrappedStretch(surface, a == 0 ? x0 + step : x0, a == 1 ? x1 + step : x1, side, up);
        wrappedStretch(surface, a == 0 ? x0 - step : x0, a == 1 ? x1 - step : x1, side, down);
        EXPECT_NEAR(stretch.slope[a][i], (up.length - down.length) / (2.0 * h), 1e-8);
        for (int b = 0; b < 2; ++b) {
          const Eigen::Vector3d change = (up.slope[b] - down.slope[b]) / (2.0 * h);
          EXPECT_LT((stretch.curvature[b][a].col(i) - change).norm(), 1e-6 * (1.0 + change.norm())) << a << i << b;
        }
      }
    }
    PlacedSurface wider = surface, thinner = surface;
    wider.radius += h, thinner.radius -= h;
    wrappedStretch(wider, x0, x1, side, up);
    wrappedStretch(thinner, x0, x1, side, down);
    EXPECT_NEAR(stretch.by_radius, (up.length - down.length) / (2.0 * h), 1e-8);
    for (int a = 0; a < 2; ++a) {
      EXPECT_LT((stretch.slope_by_radius[a] - (up.slope[a] - down.slope[a]) / (2.0 * h)).norm(), 1e-6);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, StretchOverSurface, testing::Range(0, 24));

TEST(Stretch, ItsSlopeIsContinuousWhereContactBegins) {
  const PlacedSurface surface{Surface::Shape::kCylinder, 0.02, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  Stretch before, after;
  const Eigen::Vector3d x1(0.03, 0.1, 0.02);
  wrappedStretch(surface, {0.0, -0.1, 0.02 + 1e-9}, x1, nullptr, before);
  wrappedStretch(surface, {0.0, -0.1, 0.02 - 1e-9}, x1, nullptr, after);
  EXPECT_FALSE(before.wrapped);
  EXPECT_TRUE(after.wrapped);
  EXPECT_NEAR(before.length, after.length, 1e-9);
  for (int a = 0; a < 2; ++a) EXPECT_LT((before.slope[a] - after.slope[a]).norm(), 1e-7);
}

TEST(Stretch, PassesOnTheSideThatIsAskedFor) {
  const PlacedSurface surface{Surface::Shape::kCylinder, 0.02, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  const Eigen::Vector3d x0(0.0, -0.1, 0.03), x1(0.0, 0.1, 0.03), above(0.0, 0.0, 0.1), below(0.0, 0.0, -0.1);
  Stretch stretch;
  wrappedStretch(surface, x0, x1, &above, stretch);
  EXPECT_FALSE(stretch.wrapped);
  wrappedStretch(surface, x0, x1, &below, stretch);
  ASSERT_TRUE(stretch.wrapped);
  // By hand: both tangents from (0.1, 0.03), the arc below.
  const double far = std::hypot(0.1, 0.03), free = std::sqrt(far * far - 0.02 * 0.02);
  const double down = std::numbers::pi / 2.0 + std::atan2(0.03, 0.1);  // from an end's direction to straight down
  EXPECT_NEAR(stretch.length, 2.0 * (free + 0.02 * (down - std::acos(0.02 / far))), 1e-12);
}

TEST(Stretch, EndsInsideAreStraight) {
  const PlacedSurface surface{Surface::Shape::kSphere, 0.05, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()};
  Stretch stretch;
  wrappedStretch(surface, {0.0, 0.0, 0.04}, {0.1, 0.1, 0.0}, nullptr, stretch);
  EXPECT_FALSE(stretch.wrapped);
  EXPECT_NEAR(stretch.length, std::sqrt(0.1 * 0.1 + 0.1 * 0.1 + 0.04 * 0.04), 1e-15);
}

}  // namespace
}  // namespace simgap
