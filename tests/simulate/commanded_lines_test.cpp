// What takes a command instead of being wound by a motor: a pneumatic muscle, a motor and a servo at joints. Forces
// against 002's law, derivatives against differences, rests against tests/reality/pneumatic, whose statics
// (tests/bench/make_pneumatic_data.py) share no code with the models.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/actuator/pam.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/pose_protocol.h"
#include "simgap/simulate/replay.h"
#include "support/files.h"

namespace simgap {
namespace {

using testing::HasSubstr;

const TendonKind& kindNamed(std::string_view name) {
  return **std::ranges::find(tendon_kinds::all(), name, &TendonKind::name);
}

constexpr TendonParameters kMuscle = {8e-3, -6e-3, 1e-3, 4000.0, 0.2, 0.24, 60.0};

ArmModel pneumaticArm() { return readArm(YamlNode::load(test::sourceFile("tests/reality/pneumatic/arm.yaml"))); }

PoseSet rests(const ArmModel& model) {
  return readPoseSet(CsvTable::load(test::sourceFile("tests/reality/pneumatic/rests.csv")), model.poseLayout());
}

TEST(PneumaticMuscle, PullsWithTheForceThatThePressureLawHas) {
  const TendonKind& kind = kindNamed("pneumatic-muscle");
  const Pam pam{.a = kMuscle[0], .b = kMuscle[1], .c = kMuscle[2], .k = kMuscle[3]};
  int pulling = 0;
  for (int i = 0; i <= 12; ++i) {
    for (int k = 0; k < 19; ++k) {
      const double pressure = 5e4 * i, length = 0.19 + 0.0037 * k;
      const double contraction = (kMuscle[5] - length) / kMuscle[4];
      const auto expected = pam.force(pressure, contraction);
      if (!expected || contraction > 0.25) continue;  // beyond its end the law's parabola rises again
      EXPECT_NEAR(kind.pull(kMuscle, length, pressure).force, *expected, 1e-9 * (1.0 + *expected));
      pulling += *expected > 10.0;
    }
  }
  EXPECT_GT(pulling, 50);
  EXPECT_EQ(kind.pull(kMuscle, 0.17, 3e5).force, 0.0) << "contracted to its end";
  EXPECT_EQ(kind.force(kMuscle, 0.17, 1.0, 3e5), 0.0) << "slack, it does not damp";
}

TEST(CommandedLines, AllDerivativesAgreeWithDifferences) {
  const struct {
    const char* kind;
    TendonParameters p;
    double at, command, h;
  } cases[] = {{"pneumatic-muscle", kMuscle, 0.22, 2.3e5, 10.0},
               {"pneumatic-muscle", kMuscle, 0.236, 4e4, 10.0},
               {"pneumatic-muscle", {6e-3, -3e-3, 1e-3, 4000.0, 0.2, 0.24, 0.0}, 0.17, 2e5, 10.0},  // never slack
               {"joint-motor", {0.03, 60.0, 0.7, 0.05}, 0.4, 1.2, 1e-4},
               {"joint-servo", {1.5, 0.03, 0.05}, 0.4, 0.1, 1e-4},
               {"line-servo", {900.0, 0.03, 5.0}, 0.14, 0.1, 1e-5}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.kind);
    const TendonKind& kind = kindNamed(c.kind);
    const TendonPull at = kind.pull(c.p, c.at, c.command);
    const auto slope = [](double ahead, double behind, double h) { return (ahead - behind) / (2.0 * h); };
    const double h = 1e-6, scale = 1.0 + std::abs(at.force);
    const TendonPull ahead = kind.pull(c.p, c.at + h, c.command), behind = kind.pull(c.p, c.at - h, c.command);
    EXPECT_NEAR(at.force, slope(ahead.energy, behind.energy, h), 1e-5 * scale);
    EXPECT_NEAR(at.stiffness, slope(ahead.force, behind.force, h), 1e-5 * (1.0 + std::abs(at.stiffness)));
    const double more = kind.pull(c.p, c.at, c.command + c.h).force, less = kind.pull(c.p, c.at, c.command - c.h).force;
    EXPECT_NEAR(at.by_command, slope(more, less, c.h), 1e-6 * std::abs(at.by_command));
    for (std::size_t i = 0; i < kind.parameters.size(); ++i) {
      TendonParameters up = c.p, down = c.p;
      const double step = 1e-6 * std::max(1e-3, std::abs(c.p[i]));
      up[i] += step;
      down[i] -= step;
      const double expected = slope(kind.pull(up, c.at, c.command).force, kind.pull(down, c.at, c.command).force, step);
      EXPECT_NEAR(at.by_parameter[i], expected, 1e-4 * (1.0 + std::abs(expected))) << kind.parameters[i].name;
    }
  }
}

TEST(PneumaticArm, RestsWhereTheIndependentStaticsFindIt) {
  const ArmModel model = pneumaticArm();
  const PoseSet set = rests(model);
  EquilibriumArm arm(model);
  ASSERT_GE(set.poses.size(), 20U);
  for (const Pose& pose : set.poses) {
    ASSERT_TRUE(arm.solve(pose.shafts).stable) << pose.name;
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      EXPECT_NEAR(arm.joints()[j].angle, pose.joints[j].angle, 1e-7) << model.joints[j].name << " of " << pose.name;
    }
  }
}

TEST(PneumaticArm, SensitivitiesOfTheRestAgreeWithDifferencesOfRests) {
  const ArmModel model = pneumaticArm();
  const Pose pose = rests(model).poses[4];
  std::vector<std::string> names;
  std::vector<double> values;
  ArmModel copy = model;
  visitParameters(copy, [&](const ParameterPath& path, const ParameterKind&, double& value) {
    if (path.group != "tendons") return;
    names.push_back(path.str());
    values.push_back(value);
  });
  EquilibriumArm arm(model);
  ASSERT_TRUE(arm.solve(pose.shafts).stable);
  arm.linearise();
  const Eigen::Index n = arm.energy().degreesOfFreedom();
  Eigen::MatrixXd columns(n, names.size());
  arm.sensitivities(staticParameters(model, names), columns);
  const auto restOf = [&](const ArmModel& changed, const std::vector<double>& commands) {
    EquilibriumArm other(changed);
    EXPECT_TRUE(other.solveFrom(arm.joints(), commands).stable);
    Eigen::VectorXd q(n);
    for (Eigen::Index j = 0; j < n; ++j) q[j] = other.joints()[j].angle;
    return q;
  };
  int moving = 0;
  for (std::size_t p = 0; p < names.size(); ++p) {
    const double h = 1e-5 * std::max(1e-3, std::abs(values[p]));
    const auto at = [&](double change) {
      ArmModel changed = model;
      visitParameters(changed, [&](const ParameterPath& path, const ParameterKind&, double& value) {
        if (path.str() == names[p]) value += change;
      });
      return restOf(changed, pose.shafts);
    };
    const Eigen::VectorXd slope = (at(h) - at(-h)) / (2.0 * h);
    EXPECT_LT((columns.col(p) - slope).norm(), 1e-4 * (1.0 + slope.norm())) << names[p];
    moving += slope.norm() > 1e-6;
  }
  EXPECT_GE(moving, 16);
  Eigen::MatrixXd by_command(n, std::ssize(pose.shafts));
  arm.energy().differentiateByShafts(by_command);
  arm.applyInverseHessian(by_command);
  for (std::size_t c = 0; c < pose.shafts.size(); ++c) {
    const double h = 1e-5 * std::abs(pose.shafts[c]);
    std::vector<double> more = pose.shafts, less = pose.shafts;
    more[c] += h;
    less[c] -= h;
    const Eigen::VectorXd slope = (restOf(model, more) - restOf(model, less)) / (2.0 * h);
    EXPECT_LT((by_command.col(c) + slope).norm(), 1e-4 * slope.norm()) << c;
  }
}

TEST(PneumaticArm, RestsInTheSimulationWhereItsEnergyIsLeast) {
  const ArmModel model = pneumaticArm();
  BulletArm arm(model, {});
  PoseProtocol protocol;
  protocol.acquisition = 0.5;
  protocol.settle = 10.0;
  protocol.max_velocity = 1e-4;
  for (const Pose& pose : {rests(model).poses[0], rests(model).poses[7]}) {
    const PoseOutcome outcome = replayPose(arm, pose.shafts, protocol);
    ASSERT_EQ(outcome.status, PoseStatus::kSteady);
    EXPECT_EQ(outcome.shafts, pose.shafts);
    for (std::size_t j = 0; j < model.joints.size(); ++j) {  // 1 mNm of friction holds it by less than this
      EXPECT_NEAR(outcome.joints[j].angle, pose.joints[j].angle, 2e-3) << model.joints[j].name;
    }
  }
}

TEST(PneumaticArm, IsWrittenAsItWasRead) {
  const ArmModel model = pneumaticArm();
  const std::string text = writeArm(model);
  EXPECT_EQ(writeArm(readArm(YamlNode::parse(text, "again.yaml"))), text);
  EXPECT_EQ(model.commands(), 4U);
}

std::string refusedPoses(const std::string& header, const std::string& row) {
  const ArmModel model = pneumaticArm();
  return test::errorOf([&] { readPosesFor(model, CsvTable::parse(header + "\n" + row + "\n", "poses.csv")); });
}

TEST(PneumaticArm, RefusesCommandsThatItCannotHave) {
  const std::string joints = ",shoulder_rad,elbow_rad,wrist_rad";
  EXPECT_THAT(refusedPoses("pose,current_shoulder_A,pressure_biceps_bar,target_wrist_rad" + joints, "a,1,2,0.1,0,1,0"),
              HasSubstr("pressure_triceps"));
  EXPECT_THAT(refusedPoses("pose,current_shoulder_A,pressure_biceps_bar,pressure_triceps_bar,pressure_calf_bar,"
                           "target_wrist_rad" +
                               joints,
                           "a,1,2,2,2,0.1,0,1,0"),
              HasSubstr("poses.csv:1: column pressure_calf_bar: nothing in the model that takes such a command"));
  EXPECT_THAT(refusedPoses("pose,current_shoulder_A,pressure_biceps_Pa,pressure_triceps_bar,target_wrist_rad" + joints,
                           "a,1,2,2,0.1,0,1,0"),
              HasSubstr("pressure_biceps_Pa: found at most 2, expected pressures in Pa; they look like bar"));
  EXPECT_THAT(
      refusedPoses("pose,current_shoulder_A,pressure_biceps_bar,pressure_triceps_bar,target_wrist_rad" + joints,
                   "a,1,2,2,35,0,1,0.6"),
      HasSubstr("target_wrist_rad: found 35, more than two turns where no joint makes one; targets in degrees?"));
}

}  // namespace
}  // namespace simgap
