// The same arm with stronger forces rests where it rested: its poses have the same causes.
#include <gtest/gtest.h>

#include <cmath>

#include "support/drawn_poses.h"
#include "support/scaled_arm.h"

namespace simgap {
namespace {

constexpr double kStronger = 80.0;

Diagnosis diagnoseWithForces(const reality::PoseDraw& draw, double factor) {
  std::vector<ParameterSpace::Choice> parameters = test::paperConfig().parameters;
  for (ParameterSpace::Choice& choice : parameters) {
    if (choice.pattern.find("stiffness") != std::string::npos) *choice.upper *= kStronger;  // room for both
  }
  PoseDiagnosisOptions options;
  options.effects = {"passive-joint-torque", "joint-stiction", "joint-centre-offset", "payload", "pulley-friction"};
  return diagnosePoses(test::withForces(test::modelOf(draw), factor), test::posesOf(draw, draw.poses), parameters,
                       test::paperConfig().noise, options, [](const std::string&, double) {})
      .diagnosis;
}

/// The parameter is as many times as large.
void expectTheSame(const Diagnosis& plain, const Diagnosis& strong, std::string_view in_proportion) {
  EXPECT_EQ(plain.verdict, strong.verdict) << plain.sentence << "\n" << strong.sentence;
  ASSERT_EQ(plain.causes.size(), strong.causes.size()) << plain.sentence << "\n" << strong.sentence;
  for (std::size_t c = 0; c < plain.causes.size(); ++c) {
    const Cause &one = plain.causes[c], &other = strong.causes[c];
    EXPECT_EQ(test::labelOf(one.effect, one.target), test::labelOf(other.effect, other.target));
    EXPECT_NEAR(one.gain_heldout.value, other.gain_heldout.value, 0.02);
    for (std::size_t i = 0; i < one.parameters.size(); ++i) {
      const double factor = one.parameters[i].name == in_proportion ? kStronger : 1.0;
      EXPECT_NEAR(factor * one.parameters[i].value, other.parameters[i].value,
                  0.03 * std::abs(factor * one.parameters[i].value))
          << one.parameters[i].name;
    }
  }
}

TEST(PoseForces, ASpringIsNamedWhateverItsStrength) {
  reality::PoseDrawOptions options;
  options.poses = 40;
  options.effect = "passive-joint-torque";
  const reality::PoseDraw draw = reality::drawPoses(11, options);
  const Diagnosis plain = diagnoseWithForces(draw, 1.0);
  ASSERT_FALSE(plain.causes.empty()) << plain.sentence;
  EXPECT_EQ(plain.causes[0].effect, "passive-joint-torque");
  expectTheSame(plain, diagnoseWithForces(draw, kStronger), "stiffness");
}

TEST(SlowPoseForces, FrictionIsNamedWhateverItsStrength) {
  reality::PoseDrawOptions options;
  options.effect = "joint-stiction";
  const reality::PoseDraw draw = reality::drawPoses(11, options);
  const Diagnosis plain = diagnoseWithForces(draw, 1.0);
  ASSERT_FALSE(plain.causes.empty()) << plain.sentence;
  EXPECT_EQ(plain.causes[0].effect, "joint-stiction");
  expectTheSame(plain, diagnoseWithForces(draw, kStronger), "torque");
}

}  // namespace
}  // namespace simgap
