// Sizes that no arm has are no findings, however probable they make its poses.
#include "diagnose/poses/impossible_sizes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pose_rig.h"

namespace simgap::test {
namespace {

std::string saidOf(const PoseRig& rig, const std::string& effect, const std::string& target, EffectParameters p) {
  PoseFit fit(rig.problem, rig.set.poses, {{findArmEffect(effect), target, p}});
  Eigen::VectorXd z = fit.extended(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.ordinary())));
  fit.setSolution(z);
  return impossibleSize(fit, 0);
}

TEST(ImpossibleSizes, AreFrictionThatDrivesAndBodiesOfNoMass) {
  const PoseRig rig(21, {.poses = 10, .causes = 0});
  const std::string elbow = rig.problem.nominal.joints[1].name, upper_arm = rig.problem.nominal.bodies[1].name,
                    muscle = rig.problem.nominal.muscles.back().name;
  EXPECT_EQ(saidOf(rig, "joint-stiction", elbow, {-0.045, 0.0}), "torque = -0.045 Nm is no physical size");
  EXPECT_EQ(saidOf(rig, "joint-stiction", elbow, {0.045, 0.0}), "");
  EXPECT_EQ(saidOf(rig, "pulley-friction", muscle, {-0.11, 0.0}), "loss = -0.11 is no physical size");
  EXPECT_EQ(saidOf(rig, "muscle-wrap", muscle, {0.0, 1.0}), "radius = 0 m is no physical size");
  EXPECT_EQ(saidOf(rig, "muscle-wrap", muscle, {0.02, 1.0}), "");
  EXPECT_EQ(saidOf(rig, "payload", upper_arm, {-0.3, 0.1}), "");  // lighter than its file says
  EXPECT_NE(saidOf(rig, "payload", upper_arm, {-1.9, 0.1}).find(upper_arm + " would have a mass of -"),
            std::string::npos);
  EXPECT_EQ(saidOf(rig, "gravity-tilt", "", {0.1, -0.15}), "");
  EXPECT_EQ(saidOf(rig, "gravity-tilt", "", {0.41, -0.34}), "a base that is 31 deg off level would be seen");
  // Exchanged columns of shafts passed for markers that were turned by 28 degrees.
  EXPECT_EQ(saidOf(rig, "marker-frame-offset", upper_arm, {0.0, -0.485, 0.0}),
            "markers that are 28 deg askew on their body would be seen");
  EXPECT_EQ(saidOf(rig, "marker-frame-offset", upper_arm, {0.0, 0.2, 0.0}), "");
}

// An angle sensor that is bent passed for a stop that pushes the joint into itself.
TEST(ImpossibleSizes, AreSpringsThatPushAway) {
  PoseRig rig(21, {.poses = 10, .causes = 0});
  Joint& elbow = rig.problem.nominal.joints[1];
  EXPECT_EQ(saidOf(rig, "passive-joint-torque", elbow.name, {-2.93, 0.2, -1.0}),
            "what pushes " + elbow.name + " away from its rest, by 2.93 Nm/rad, is nothing elastic");
  EXPECT_EQ(saidOf(rig, "passive-joint-torque", elbow.name, {2.93, 0.2, -1.0}), "");
  elbow.spring_stiffness = 4.0;  // softer than the model says
  EXPECT_EQ(saidOf(rig, "passive-joint-torque", elbow.name, {-2.93, 0.2, -1.0}), "");
}

// Poses of a line that friction would pull instead of hold.
TEST(ImpossibleSizes, AreRefusedAndSaidWithTheCandidate) {
  PoseRig rig(21, {.poses = 60, .causes = 0});
  ArmModel driven = rig.plain.model();
  const std::string muscle = driven.muscles[9].name;
  driven.extensions.push_back(makeExtension(*findArmEffect("pulley-friction"), muscle, {-0.18, 1.0}));
  EquilibriumArm arm(driven), plain(rig.plain.model());
  for (Pose& pose : rig.set.poses) {
    arm.setHistory(pose.time, pose.shafts_before);
    ASSERT_TRUE(arm.solveFrom(pose.joints, pose.shafts).stable);
    ASSERT_TRUE(plain.solveFrom(pose.joints, pose.shafts).stable);
    pose.joints[1].angle += arm.joints()[1].angle - plain.joints()[1].angle;
  }
  PoseDiagnosisOptions options;
  options.effects = {"pulley-friction"};
  const Diagnosis found = diagnosePoses(rig.problem.nominal, rig.set, rig.problem.parameters, rig.problem.noise,
                                        options, [](const std::string&, double) {})
                              .diagnosis;
  EXPECT_TRUE(found.causes.empty()) << found.sentence;
  const auto refused = std::ranges::find(found.candidates, muscle, &Candidate::target);
  ASSERT_NE(refused, found.candidates.end()) << found.sentence;
  EXPECT_NE(refused->reason.find("is no physical size"), std::string::npos) << refused->reason;
}

}  // namespace
}  // namespace simgap::test
