// The contract of every registered effect on an arm: its derivatives, its neutral value, its file, and that both
// simulations take it alike.
#include "simgap/model/arm/arm_effect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/pose_protocol.h"
#include "simgap/simulate/robot_exchange.h"
#include "support/arms.h"
#include "support/files.h"
#include "support/statics.h"

namespace simgap {
namespace {

struct EffectCase {
  const ArmEffect* effect;
  std::string target;
  EffectParameters p;
};

// Least distance of a muscle's ends from the joints it crosses, on the bodies next to them.
double nearestEnd(const ArmModel& model, const std::string& name) {
  double nearest = 1.0;
  for (const Muscle& muscle : model.muscles) {
    if (muscle.name != name) continue;
    for (const int j : jointsCrossed(model, muscle)) {
      for (const Attachment& end : muscle.attachments) {
        const Joint& joint = model.joints[j];
        if (end.body == joint.parent) nearest = std::min(nearest, (end.point - joint.parent_position).norm());
        if (end.body == joint.child) nearest = std::min(nearest, (end.point - joint.child_position).norm());
      }
    }
  }
  return nearest;
}

// A start of each effect, moved off whatever is special about it, on every target.
std::vector<EffectCase> effectCases() {
  const ArmModel model = test::exampleArm();
  std::vector<EffectCase> all;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (effect->needs_motion) continue;  // motion_effect_test.cpp
    for (const std::string& target : effectTargets(*effect, model)) {
      for (EffectParameters p : effect->starts) {
        for (std::size_t i = 0; i < effect->parameters.size(); ++i) {
          const ArmEffectParameter& parameter = effect->parameters[i];
          if (parameter.fitted) p[i] += (i == 0 ? 0.3 : 0.1) * parameter.scale;
        }
        // Beyond what the nearer end allows, a radius is cut off, and there derivatives by attachments leave that out.
        if (effect->path) p[0] = std::min(p[0], 0.7 * nearestEnd(model, target));
        Extension extension = makeExtension(*effect, target, p);
        if (checkExtension(extension, model).empty()) all.push_back({effect, target, p});
      }
    }
  }
  return all;
}

ArmModel extended(const EffectCase& c) {
  ArmModel model = test::exampleArm();
  model.extensions = {makeExtension(*c.effect, c.target, c.p)};
  return model;
}

// Every tenth pose of the dense set; recorded at different times.
std::vector<Pose> somePoses() {
  const PoseSet set = readPoseSet(CsvTable::load(test::sourceFile("data/arm-dense/poses_calibration.csv")),
                                  test::exampleArm().poseLayout());
  std::vector<Pose> some;
  for (std::size_t p = 3; p < set.poses.size(); p += 10) some.push_back(set.poses[p]);
  return some;
}

std::vector<JointPosition> effectDisplaced(const ArmModel& model, std::vector<JointPosition> joints,
                                           const Eigen::VectorXd& w) {
  Eigen::Index d = 0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (model.joints[j].type == JointType::kSpherical) {
      const Eigen::Vector3d v = w.segment<3>(d);
      const double angle = v.norm();
      if (angle > 0.0)
        joints[j].rotation = joints[j].rotation * Eigen::Quaterniond(Eigen::AngleAxisd(angle, v / angle));
    } else {
      joints[j].angle += w[d];
    }
    d += model.joints[j].degreesOfFreedom();
  }
  return joints;
}

class ArmEffects : public testing::TestWithParam<EffectCase> {
 protected:
  void place(PotentialEnergy& energy, const Pose& pose) const {
    energy.setHistory(pose.time, pose.shafts_before);
    energy.setShafts(pose.shafts);
    energy.evaluate(pose.joints);
  }
  std::vector<Pose> poses_ = somePoses();
};

TEST_P(ArmEffects, GradientAndHessianAgreeWithDifferencesOfTheEnergy) {
  const ArmModel model = extended(GetParam());
  PotentialEnergy energy(model);
  const int n = energy.degreesOfFreedom();
  for (const Pose& pose : poses_) {
    place(energy, pose);
    const Eigen::VectorXd gradient = energy.gradient();
    const Eigen::MatrixXd hessian = energy.hessian();
    const auto at = [&](const Eigen::VectorXd& w) {
      energy.evaluate(effectDisplaced(model, pose.joints, w));
      return energy.energy();
    };
    const double h = 1e-4;
    for (int i = 0; i < n; ++i) {
      const Eigen::VectorXd a = h * Eigen::VectorXd::Unit(n, i);
      EXPECT_NEAR(gradient[i], (at(a) - at(-a)) / (2.0 * h), 1e-5) << pose.name << ", " << i;
      for (int j = 0; j <= i; ++j) {
        const Eigen::VectorXd b = h * Eigen::VectorXd::Unit(n, j);
        const double second = (at(a + b) - at(a - b) - at(b - a) + at(-a - b)) / (4.0 * h * h);
        EXPECT_NEAR(hessian(i, j), second, 1e-4) << pose.name << ", " << i << ", " << j;
        EXPECT_EQ(hessian(i, j), hessian(j, i));
      }
    }
  }
}

TEST_P(ArmEffects, EveryParameterDerivativeAgreesWithDifferencesOfTheGradient) {
  ArmModel model = extended(GetParam());
  std::vector<std::string> names;
  std::vector<double> values;
  visitParameters(model, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    names.push_back(path.str());
    values.push_back(value);
  });
  const std::vector<StaticParameter> parameters = staticParameters(model, names);
  const bool payload = GetParam().effect->mass != nullptr;
  for (const Pose& pose : {poses_[0], poses_[3], poses_[7]}) {
    PotentialEnergy energy(model);
    place(energy, pose);
    Eigen::MatrixXd columns(energy.degreesOfFreedom(), names.size());
    energy.differentiate(parameters, columns);
    Eigen::MatrixXd by_shaft(energy.degreesOfFreedom(), model.muscles.size());
    energy.differentiateByShafts(by_shaft);
    for (std::size_t p = 0; p < names.size(); ++p) {
      // The way to a payload leads from the joint through the centre of mass: that these move is left out.
      if (payload && (names[p].starts_with("bodies") || names[p].find("child_position") != std::string::npos)) continue;
      double h = 1e-6 * std::max(0.1, std::abs(values[p]));
      for (const ArmEffectParameter& own : GetParam().effect->parameters) {
        if (names[p].starts_with("extensions") && names[p].ends_with(own.name)) h = 1e-6 * own.scale;
      }
      const auto gradientAt = [&](double value) {
        ArmModel changed = model;
        std::size_t k = 0;
        visitParameters(changed, [&](const ParameterPath&, const ParameterKind&, double& number) {
          if (k++ == p) number = value;
        });
        PotentialEnergy other(changed);
        place(other, pose);
        return Eigen::VectorXd(other.gradient());
      };
      const Eigen::VectorXd slope = (gradientAt(values[p] + h) - gradientAt(values[p] - h)) / (2.0 * h);
      const double scale = std::max(1.0, slope.lpNorm<Eigen::Infinity>());
      EXPECT_LT((columns.col(p) - slope).lpNorm<Eigen::Infinity>(), 1e-6 * scale)
          << pose.name << ", " << names[p] << ": " << columns.col(p).transpose() << " for " << slope.transpose();
    }
    for (std::size_t m = 0; m < model.muscles.size(); ++m) {
      const auto gradientAt = [&](double h) {
        Pose wound = pose;
        wound.shafts[m] += h;
        place(energy, wound);
        return Eigen::VectorXd(energy.gradient());
      };
      const Eigen::VectorXd slope = (gradientAt(1e-5) - gradientAt(-1e-5)) / 2e-5;
      EXPECT_LT((by_shaft.col(m) - slope).lpNorm<Eigen::Infinity>(), 1e-6) << "shaft " << m;
    }
  }
}

// What the capture sees, by the effect's own parameters: through equilibrium, stiction and markers.
TEST_P(ArmEffects, ObservedSensitivitiesAgreeWithDifferences) {
  const EffectCase& c = GetParam();
  const ArmModel model = extended(c);
  std::vector<std::string> names;
  for (const ArmEffectParameter& p : c.effect->parameters) {
    if (p.fitted)
      names.push_back("extensions." + effectLabel(model.extensions[0].effect, model.extensions[0].target) + "." +
                      std::string(p.name));
  }
  const std::vector<StaticParameter> parameters = staticParameters(model, names);
  int moved = 0;
  for (const Pose& pose : poses_) {
    EquilibriumArm arm(model);
    arm.setHistory(pose.time, pose.shafts_before);
    if (!arm.solveFrom(pose.joints, pose.shafts).stable) continue;
    const std::vector<JointPosition> equilibrium = arm.joints();
    const std::vector<JointPosition> seen = arm.observe(pose.shafts, pose.shafts_before);
    arm.linearise();
    Eigen::MatrixXd columns(arm.energy().degreesOfFreedom(), names.size());
    arm.observedSensitivities(parameters, columns);
    std::size_t fitted = 0;
    for (std::size_t i = 0; i < c.effect->parameters.size(); ++i) {
      if (!c.effect->parameters[i].fitted) continue;
      const auto column = columns.col(fitted++);
      const double h = 1e-4 * c.effect->parameters[i].scale;
      const auto at = [&](double step) {
        EffectCase changed = c;
        changed.p[i] += step;
        EquilibriumArm other(extended(changed));
        other.setHistory(pose.time, pose.shafts_before);
        EXPECT_TRUE(other.solveFrom(equilibrium, pose.shafts).stable);
        return other.observe(pose.shafts, pose.shafts_before);
      };
      const std::vector<JointPosition> plus = at(h), minus = at(-h);
      for (std::size_t j = 0; j < plus.size(); ++j) {
        const int d = arm.energy().firstDof(static_cast<int>(j));
        if (arm.atStop(d)) continue;
        if (model.joints[j].type == JointType::kRevolute) {
          EXPECT_NEAR(column[d] * c.effect->parameters[i].scale,
                      (plus[j].angle - minus[j].angle) / (2.0 * h) * c.effect->parameters[i].scale, 1e-5);
          continue;
        }
        const Eigen::Quaterniond turn = minus[j].rotation.conjugate() * plus[j].rotation;
        const Eigen::Vector3d slope = 2.0 * (turn.w() < 0.0 ? -1.0 : 1.0) * turn.vec() / (2.0 * h);
        EXPECT_LT((column.segment<3>(d) - slope).norm() * c.effect->parameters[i].scale, 2e-5)
            << pose.name << ", " << names[fitted - 1];
      }
      moved += column.norm() > 0.0;
    }
  }
  if (c.effect->path == nullptr && c.effect->joint_torque == nullptr) {
    EXPECT_GT(moved, 0);
  }
}

TEST_P(ArmEffects, NeutralChangesNothing) {
  EffectCase c = GetParam();
  for (std::size_t i = 0; i < c.effect->parameters.size(); ++i) {
    if (c.effect->parameters[i].fitted && (i == 0 || c.effect->parameters[i].neutral == 0.0)) {
      c.p[i] = c.effect->parameters[i].neutral;
    }
  }
  EquilibriumArm plain(test::exampleArm()), neutral(extended(c));
  for (const Pose& pose : poses_) {
    neutral.setHistory(pose.time, pose.shafts_before);
    ASSERT_EQ(plain.solve(pose.shafts).stable, neutral.solve(pose.shafts).stable);
    EXPECT_LT(
        test::largestError(plain.energy().model(), plain.joints(), neutral.observe(pose.shafts, pose.shafts_before)),
        1e-7);
  }
}

TEST_P(ArmEffects, FilesReadBackTheSame) {
  const ArmModel model = extended(GetParam());
  const ArmModel again = readArm(YamlNode::parse(writeArm(model), "arm.yaml"));
  ASSERT_EQ(again.extensions.size(), 1u);
  EXPECT_EQ(writeArm(again), writeArm(model));
  EXPECT_EQ(resolveExtensions(again)[0].p, resolveExtensions(model)[0].p);
}

std::string caseName(const testing::TestParamInfo<EffectCase>& info) {
  std::string name = std::string(info.param.effect->name) + "_" + info.param.target + "_" + std::to_string(info.index);
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(c); }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, ArmEffects, testing::ValuesIn(effectCases()), caseName);

// Both simulations come to the same rest, for one target of each effect; stiction is friction in one and a lag in the
// other, and only alike in size.
class BothSimulations : public testing::TestWithParam<EffectCase> {};

std::vector<EffectCase> onePerEffect() {
  std::vector<EffectCase> some;
  for (const EffectCase& c : effectCases()) {
    const bool seen = !some.empty() && some.back().effect == c.effect;
    if (!seen && !c.effect->stiction) some.push_back(c);
  }
  for (EffectCase& c : some) {
    if (c.effect->path) c.p[0] = 0.06;
    if (c.effect->joint_torque) c.p[1] = 0.05;
    if (c.effect->hinge_axis) c.p[0] = 0.2;
    if (c.effect->name == "payload") c.target = "forearm";
  }
  return some;
}

TEST_P(BothSimulations, ComeToTheSameRest) {
  ArmModel model = extended(GetParam());
  for (Joint& joint : model.joints) joint.coulomb_friction = 0.0;
  ArmModel plain = model;
  plain.extensions.clear();
  const PoseProtocol protocol = test::patientProtocol(1e-5);
  BulletArm bullet(model, protocol.arm);
  EquilibriumArm equilibrium(model), without(plain);
  double effect = 0.0;
  const std::vector<Pose> poses = somePoses();
  for (const Pose& pose : {poses[0], poses[4], poses[7]}) {
    bullet.setHistory(pose.time, pose.shafts_before);
    const PoseOutcome outcome = replayPose(bullet, pose.shafts, protocol);
    ASSERT_EQ(outcome.status, PoseStatus::kSteady);
    equilibrium.setHistory(pose.time, pose.shafts_before);
    ASSERT_TRUE(equilibrium.solveFrom(outcome.joints, outcome.shafts).stable);
    EXPECT_LT(toDegrees(test::largestError(model, equilibrium.observe(outcome.shafts, {}), outcome.joints)), 0.01)
        << pose.name;
    ASSERT_TRUE(without.solveFrom(outcome.joints, outcome.shafts).stable);
    effect = std::max(effect, test::largestError(model, without.joints(), outcome.joints));
  }
  EXPECT_GT(toDegrees(effect), 0.1) << "the effect does nothing here";
}

TEST_P(BothSimulations, AreAlikeForNumbersThatSayTheSame) {
  const ArmModel model = extended(GetParam());
  ArmModel numbers = model;
  const std::vector<Extension> worked_in = workExtensionsIn(numbers);
  ASSERT_EQ(worked_in.size() + numbers.extensions.size(), 1u);
  const RobotExchange exchange = exchangeRobot({writeArm(model), "arm.yaml"}, {}, "arm.xml", {});
  const bool said = std::ranges::any_of(exchange.written, [](const ExchangeRemark& remark) {
    return remark.done == "worked into the robot's numbers" && !remark.matters;
  });
  EXPECT_EQ(said, !worked_in.empty());
  EXPECT_EQ(exchange.model.extensions.empty(), !worked_in.empty());
  EquilibriumArm extended_arm(model), of_numbers(numbers);
  for (const Pose& pose : somePoses()) {
    for (EquilibriumArm* arm : {&extended_arm, &of_numbers}) {
      arm->setHistory(pose.time, pose.shafts_before);
      ASSERT_TRUE(arm->solve(pose.shafts).stable) << pose.name;
    }
    EXPECT_LT(test::largestError(model, of_numbers.joints(), extended_arm.joints()), 1e-7) << pose.name;
  }
}

INSTANTIATE_TEST_SUITE_P(One, BothSimulations, testing::ValuesIn(onePerEffect()), caseName);

TEST(ArmExtensions, WhatIsWrongWithOneIsSaidWithItsLine) {
  const std::string arm = writeArm(test::exampleArm());
  const auto error = [&](const std::string& entry) {
    return test::errorOf([&] { readArm(YamlNode::parse(arm + "extensions:\n  - " + entry + "\n", "a.yaml")); });
  };
  const std::string radius = "radius: {value: 0.03, unit: m}";
  EXPECT_NE(error("{effect: muscle-warp, parameters: {}}").find("found 'muscle-warp', expected one of"),
            std::string::npos);
  EXPECT_NE(error("{effect: muscle-wrap, target: elbow, parameters: {}}").find("expected the name of a muscle"),
            std::string::npos);
  EXPECT_NE(error("{effect: muscle-wrap, target: biceps, parameters: {" + radius + "}}").find("no parameter joint"),
            std::string::npos);
  EXPECT_NE(error("{effect: muscle-wrap, target: biceps, parameters: {" + radius + ", joint: {value: 3, unit: \"1\"}}}")
                .find("whole number of the 2 the line crosses"),
            std::string::npos);
  EXPECT_NE(error("{effect: spindle-coiling, parameters: {growth: {value: 3, unit: 1_rad}}}").find("growth = 3"),
            std::string::npos);
  EXPECT_NE(error("{effect: gravity-tilt, target: torso, parameters: {}}").find("gravity-tilt has none"),
            std::string::npos);
  const std::string bare = writeArm(test::pendulum()) +
                           "extensions:\n  - {effect: supply-sag, parameters: {resistance: {value: 0.1, unit: ohm}, "
                           "time: {value: 0.01, unit: s}}}\n";
  EXPECT_NE(test::errorOf([&] { readArm(YamlNode::parse(bare, "a.yaml")); }).find("supply-sag needs a motor"),
            std::string::npos);
}

}  // namespace
}  // namespace simgap
