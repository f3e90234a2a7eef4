// Effects on lines of any kind: wraps on routed muscles and ligaments, ligaments of another length, friction and
// elasticity of lines; stops of balls. Derivatives against differences, both simulations against each other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/ball_stop.h"
#include "simgap/model/arm/muscle_line.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/pose_protocol.h"
#include "support/arms.h"
#include "support/files.h"
#include "support/many_kinds.h"
#include "support/statics.h"

namespace simgap {
namespace {

/// With a ligament that passes beside the ball.
ArmModel effectArm() {
  return readArm(YamlNode::parse(
      test::replaced(test::kManyKinds,
                     "attachments: [{body: carriage, point_m: [0.03, 0.03, 0]}, {body: upper, point_m: [0.02, 0.03, "
                     "-0.04]}]\n    rest_length_m: 0.03",
                     "attachments: [{body: carriage, point_m: [0.02, 0.04, 0.03]}, {body: upper, point_m: [0, 0.04, "
                     "-0.06]}]\n    rest_length_m: 0.05"),
      "many.yaml"));
}

ArmModel manyKindsWith(const std::string& effect, const std::string& target, const EffectParameters& p) {
  ArmModel model = effectArm();
  model.extensions = {makeExtension(*findArmEffect(effect), target, p)};
  EXPECT_EQ(checkExtension(model.extensions[0], model), "");
  return model;
}

std::vector<JointPosition> bentPosition(const ArmModel& model) {
  std::mt19937 random(5);
  std::vector<JointPosition> joints;
  for (const Joint& joint : model.joints) {
    JointPosition position = test::ballAt(0.4, test::randomDirection(random));
    position.angle = joint.slides() ? 0.04 : 0.9;
    joints.push_back(position);
  }
  coupleJoints(model, joints);
  return joints;
}

/// A radius at which a wrap lengthens its line there, between the smallest and the largest that do.
double touchingRadius(const std::string& target, double joint) {
  ArmModel model = manyKindsWith("muscle-wrap", target, {0.0, joint});
  const std::vector<JointPosition> joints = bentPosition(model);
  PotentialEnergy energy(model);
  energy.setShafts(std::vector<double>(model.muscles.size(), 0.0));
  const auto lengths = [&](double radius) {
    model.extensions[0].parameters[0].value = radius;
    energy.setModel(model);
    energy.evaluate(joints);
    double sum = 0.0;
    for (std::size_t line = 0; line < model.muscles.size() + model.tendons.size(); ++line) sum += energy.length(line);
    return sum;
  };
  const double straight = lengths(0.0);
  double first = 0.0, last = 0.0;
  for (int i = 10; i < 400; ++i) {
    const double radius = 0.0005 * i;
    if (lengths(radius) < straight + 1e-5) continue;
    if (first == 0.0) first = radius;
    last = radius;
  }
  EXPECT_GT(last, 0.0) << target << " is never bent";
  return 0.5 * (first + last);
}

struct TendonCase {
  const char* effect;
  const char* target;
  EffectParameters p;
};

class EffectsOnLines : public testing::TestWithParam<TendonCase> {
 protected:
  EffectsOnLines() {
    EffectParameters p = GetParam().p;
    if (std::string(GetParam().effect) == "muscle-wrap") p[0] = touchingRadius(GetParam().target, p[1]);
    model_ = manyKindsWith(GetParam().effect, GetParam().target, p);
    joints_ = bentPosition(model_);
  }
  void place(PotentialEnergy& energy, const std::vector<double>& shafts) const {
    energy.setHistory(500.0, before_);
    energy.setShafts(shafts);
    energy.evaluate(joints_);
  }
  ArmModel model_;
  std::vector<JointPosition> joints_;
  std::vector<double> shafts_ = {9.0, 6.0, 8.0, 12.0}, before_ = {4.0, 9.0, 11.0, 5.0};
};

TEST_P(EffectsOnLines, GradientIsTheSlopeOfTheEnergy) {
  PotentialEnergy energy(model_);
  place(energy, shafts_);
  const Eigen::VectorXd gradient = energy.gradient();
  const Eigen::MatrixXd hessian = energy.hessian();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    for (int k = 0; k < model_.joints[j].degreesOfFreedom(); ++k) {
      const int d = energy.firstDof(static_cast<int>(j)) + k;
      const auto at = [&](double h) {
        std::vector<JointPosition> joints = joints_;
        joints[j].angle += h;
        if (!model_.joints[j].hasAxis()) {
          joints[j].rotation = joints_[j].rotation * Eigen::Quaterniond(expSo3(h * Eigen::Vector3d::Unit(k)));
        }
        energy.evaluate(joints);
        return std::pair(energy.energy(), Eigen::VectorXd(energy.gradient()));
      };
      const double h = 1e-5;
      const auto [up, gradient_up] = at(h);
      const auto [down, gradient_down] = at(-h);
      EXPECT_NEAR(gradient[d], (up - down) / (2.0 * h), 1e-5 * std::max(1.0, std::abs(gradient[d])));
      // Turns of a ball do not commute: only its own symmetric part is a second derivative.
      EXPECT_NEAR(hessian(d, d), (gradient_up[d] - gradient_down[d]) / (2.0 * h), 1e-4 * hessian.norm());
    }
  }
}

TEST_P(EffectsOnLines, NumbersAloneSayTheSame) {
  ArmModel numbers = model_;
  const bool worked_in = !workExtensionsIn(numbers).empty();
  const std::set<std::string> of_numbers_alone{"muscle-wrap", "ligament-rest-length", "joint-axis"};
  EXPECT_EQ(worked_in, of_numbers_alone.contains(GetParam().effect));
  EXPECT_EQ(numbers.extensions.empty(), worked_in);
  PotentialEnergy energy(model_), of_numbers(numbers);
  place(energy, shafts_);
  place(of_numbers, shafts_);
  EXPECT_NEAR(of_numbers.energy(), energy.energy(), 1e-12 * std::abs(energy.energy()));
  EXPECT_LT((of_numbers.gradient() - energy.gradient()).norm(), 1e-10 * energy.gradient().norm());
}

TEST_P(EffectsOnLines, EveryParameterDerivativeAgreesWithDifferences) {
  std::vector<std::string> names;
  std::vector<double> values;
  visitParameters(model_, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    names.push_back(path.str());
    values.push_back(value);
  });
  const std::vector<StaticParameter> parameters = staticParameters(model_, names);
  PotentialEnergy energy(model_);
  place(energy, shafts_);
  Eigen::MatrixXd columns(energy.degreesOfFreedom(), names.size());
  energy.differentiate(parameters, columns);
  Eigen::MatrixXd by_shaft(energy.degreesOfFreedom(), model_.muscles.size());
  energy.differentiateByShafts(by_shaft);
  bool by_effect = false;
  for (std::size_t p = 0; p < names.size(); ++p) {
    if (names[p].ends_with(".from_previous") || names[p].ends_with(".joint")) continue;
    const double h = 1e-6 * std::max(0.1, std::abs(values[p]));
    const auto gradientAt = [&](double value) {
      ArmModel changed = model_;
      std::size_t k = 0;
      visitParameters(changed, [&](const ParameterPath&, const ParameterKind&, double& number) {
        if (k++ == p) number = value;
      });
      PotentialEnergy other(changed);
      place(other, shafts_);
      return Eigen::VectorXd(other.gradient());
    };
    const Eigen::VectorXd slope = (gradientAt(values[p] + h) - gradientAt(values[p] - h)) / (2.0 * h);
    const Eigen::VectorXd column = columns.col(p);
    EXPECT_LT((column - slope).lpNorm<Eigen::Infinity>(), 1e-5 * std::max(1.0, slope.lpNorm<Eigen::Infinity>()))
        << names[p];
    by_effect |= names[p].starts_with("extensions") && slope.norm() > 1e-3;
  }
  EXPECT_TRUE(by_effect) << "the effect does nothing here";
  for (std::size_t m = 0; m < shafts_.size(); ++m) {
    const auto gradientAt = [&](double h) {
      std::vector<double> shafts = shafts_;
      shafts[m] += h;
      place(energy, shafts);
      return Eigen::VectorXd(energy.gradient());
    };
    const Eigen::VectorXd slope = (gradientAt(1e-5) - gradientAt(-1e-5)) / 2e-5;
    EXPECT_LT((by_shaft.col(m) - slope).lpNorm<Eigen::Infinity>(), 1e-5) << m;
  }
}

TEST_P(EffectsOnLines, BothSimulationsComeToTheSameRest) {
  PoseProtocol protocol = test::patientProtocol(1e-6);
  BulletArm bullet(model_, protocol.arm);
  bullet.setHistory(500.0, before_);
  const PoseOutcome outcome = replayPose(bullet, shafts_, protocol);
  ASSERT_EQ(outcome.status, PoseStatus::kSteady) << toString(outcome.status);
  EquilibriumArm equilibrium(model_);
  equilibrium.setHistory(500.0, before_);
  ASSERT_TRUE(equilibrium.solveFrom(outcome.joints, outcome.shafts).stable);
  EXPECT_LT(test::largestError(model_, equilibrium.joints(), outcome.joints), 2e-4);
}

std::string nameOf(const testing::TestParamInfo<TendonCase>& info) {
  std::string name = std::string(info.param.effect) + "_" + info.param.target;
  std::ranges::replace(name, '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, EffectsOnLines,
                         testing::Values(TendonCase{"muscle-wrap", "straight", {0.0, 2.0}},
                                         TendonCase{"muscle-wrap", "branched", {0.0, 3.0}},
                                         TendonCase{"muscle-wrap", "ligament", {0.0, 1.0}},
                                         TendonCase{"ligament-rest-length", "ligament", {-0.012}},
                                         TendonCase{"ligament-rest-length", "spring", {0.05}},
                                         TendonCase{"pulley-friction", "routed", {0.2, 1.0}},
                                         TendonCase{"pulley-friction", "straight", {0.2, 0.0}},
                                         TendonCase{"line-elasticity", "branched", {2e-3}},
                                         TendonCase{"joint-axis", "hinge", {0.2, -0.1}}),
                         nameOf);

TEST(WrapOfALine, IsDrawn) {
  const ArmModel model = manyKindsWith("muscle-wrap", "straight", {touchingRadius("straight", 2.0), 2.0});
  ArmModel plain = model;
  plain.extensions.clear();
  const std::vector<BodyInWorld> bodies = bodiesInWorld(model, bentPosition(model));
  EXPECT_EQ(muscleLine(plain, 0, bodies).size(), 2u);
  EXPECT_GT(muscleLine(model, 0, bodies).size(), 2u);
}

TEST(WrapOfALine, WhatALineCannotHaveIsRefused) {
  const ArmModel model = readArm(YamlNode::parse(test::kManyKinds, "many.yaml"));
  const auto check = [&](const char* effect, const char* target, const EffectParameters& p) {
    Extension extension = makeExtension(*findArmEffect(effect), target, p);
    return checkExtension(extension, model);
  };
  EXPECT_THAT(check("muscle-wrap", "straight", {0.03, 1.0}), testing::HasSubstr("a joint that turns"));
  EXPECT_THAT(check("muscle-wrap", "straight", {0.03, 3.0}), testing::HasSubstr("whole number of the 2"));
  EXPECT_THAT(check("ligament-rest-length", "weight", {0.01}), testing::HasSubstr("a rest length"));
  EXPECT_THAT(check("ligament-rest-length", "ligament", {-0.04}), testing::HasSubstr("above 0"));
  EXPECT_THAT(check("ligament-rest-length", "straight", {0.01}), testing::HasSubstr("expected the name of a tendon"));
}

TEST(PulleyFriction, TakesByTheWayTheShaftMoved) {
  const ArmEffect& effect = *findArmEffect("pulley-friction");
  const ShockCord cord{0.08, 500.0, 0.0};
  const auto lost = [&](double shaft, double before, double from_previous) {
    return effect
        .cord({0.2, from_previous}, 0.02, cord, {.shaft = shaft, .radius = 0.006, .time = 0.0, .before = before})
        .force;
  };
  EXPECT_DOUBLE_EQ(lost(3.0, 1.0, 1.0), -2.0);
  EXPECT_DOUBLE_EQ(lost(1.0, 3.0, 1.0), 2.0);
  EXPECT_DOUBLE_EQ(lost(1.0, 3.0, 0.0), -2.0) << "from rest";
  EXPECT_DOUBLE_EQ(lost(3.0, 3.005, 1.0), 0.0) << "it did not move";
}

TEST(BallStop, SwingAndTwistOfARotation) {
  const Eigen::Vector3d axis(0.6, 0.0, 0.8), across(0.0, 1.0, 0.0);
  const Eigen::Quaterniond q = Eigen::AngleAxisd(0.7, across) * Eigen::Quaterniond(Eigen::AngleAxisd(-0.4, axis));
  EXPECT_NEAR(swingTwist(q, axis).swing, 0.7, 1e-12);
  EXPECT_NEAR(swingTwist(q, axis).twist, -0.4, 1e-12);
  const Eigen::Quaterniond same(-q.coeffs());
  EXPECT_NEAR(swingTwist(same, axis).twist, -0.4, 1e-12);
  EXPECT_NEAR(swingTwist(Eigen::Quaterniond::Identity(), axis).swing, 0.0, 1e-12);
}

TEST(BallStop, DerivativesAgreeWithDifferences) {
  const BallStop stop{0.3, -0.2, 0.25, 40.0};
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  std::mt19937 random(3);
  int beyond = 0;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d turn = test::randomDirection(random);
    const Eigen::Quaterniond q = test::ballAt(test::uniform(random, 0.1, 2.0), turn).rotation;
    const JointTerm term = ballStop(stop, axis, q);
    beyond += term.energy > 0.0;
    const auto at = [&](const Eigen::Vector3d& w) { return ballStop(stop, axis, q * Eigen::Quaterniond(expSo3(w))); };
    const double h = 1e-5;
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(a);
      EXPECT_NEAR(term.gradient[a], (at(e).energy - at(-e).energy) / (2.0 * h), 1e-5);
      for (int b = 0; b < 3; ++b) {
        const Eigen::Vector3d f = 1e-4 * Eigen::Vector3d::Unit(b), g = 1e-4 * Eigen::Vector3d::Unit(a);
        const double second = (at(f + g).energy - at(f - g).energy - at(g - f).energy + at(-f - g).energy) / 4e-8;
        EXPECT_NEAR(term.hessian(a, b), second, 2e-3 * std::max(1.0, term.hessian.norm()));
      }
    }
  }
  EXPECT_GT(beyond, 10);
}

TEST(BallStop, HoldsAPulledArmInBothSimulationsAndInItsFile) {
  std::string text = test::kManyKinds;
  const std::string spring = "spring: {stiffness_Nm_rad: 1.5}";
  text.replace(text.find(spring), spring.size(),
               "spring: {stiffness_Nm_rad: 1.5}, limits: {axis: [0, 0, 1], swing_rad: 0.02, lower_twist_rad: -0.01, "
               "upper_twist_rad: 0.01, stiffness_Nm_rad: 30}");
  const ArmModel model = readArm(YamlNode::parse(text, "many.yaml"));
  const ArmModel again = readArm(YamlNode::parse(writeArm(model), "again.yaml"));
  EXPECT_EQ(writeArm(again), writeArm(model));
  EXPECT_EQ(again.joints[1].stop, model.joints[1].stop);
  EquilibriumArm held(model);
  const std::vector<double> shafts = {6.0, 1.0, 2.0, 1.0};
  ASSERT_TRUE(held.solve(shafts).stable);
  const double swing = swingTwist(held.joints()[1].rotation, Eigen::Vector3d::UnitZ()).swing;
  EXPECT_GT(swing, 0.02) << "nothing presses here";
  EXPECT_LT(swing, 0.15);
  PoseProtocol protocol = test::patientProtocol(1e-6);
  BulletArm bullet(model, protocol.arm);
  const PoseOutcome outcome = replayPose(bullet, shafts, protocol);
  ASSERT_EQ(outcome.status, PoseStatus::kSteady);
  ASSERT_TRUE(held.solveFrom(outcome.joints, outcome.shafts).stable);
  EXPECT_LT(test::largestError(model, held.joints(), outcome.joints), 2e-4);
}

TEST(BallStop, BadLimitsAreRefusedWithTheirLine) {
  const auto error = [](const std::string& limits) {
    std::string text = test::kManyKinds;
    const std::string spring = "spring: {stiffness_Nm_rad: 1.5}";
    text.replace(text.find(spring), spring.size(), limits);
    return test::errorOf([&] { readArm(YamlNode::parse(text, "a.yaml")); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(error("limits: {axis: [0, 0, 1], stiffness_Nm_rad: 3}"), HasSubstr("found no limit, expected swing_rad"));
  EXPECT_THAT(error("limits: {axis: [0, 0, 1], swing_rad: 1}"), HasSubstr("stiffness"));
  EXPECT_THAT(error("limits: {axis: [0, 0, 1], swing_rad: 4, stiffness_Nm_rad: 3}"), HasSubstr("between 0 and pi"));
  EXPECT_THAT(error("limits: {axis: [0, 0, 1], lower_twist_rad: 1, upper_twist_rad: 0, stiffness_Nm_rad: 3}"),
              HasSubstr("lower_twist_rad 1 is above"));
}

}  // namespace
}  // namespace simgap
