// What an arm's sizes are, and that effects follow them.
#include "simgap/model/arm/arm_sizes.h"

#include <gtest/gtest.h>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/arm_yaml.h"
#include "support/files.h"
#include "support/scaled_arm.h"

namespace simgap {
namespace {

ArmModel sampleArm() { return readArm(YamlNode::load(test::sourceFile("data/arm/arm.yaml"))); }

TEST(ArmSizes, AreOneOnTheSampleArm) {
  const ArmSizes sizes = sizesOf(sampleArm());
  EXPECT_NEAR(sizes.length, 1.0, 1e-3);
  EXPECT_NEAR(sizes.force, 1.0, 1e-3);
}

TEST(ArmSizes, OfASmallerArmAreTheSampleArms) {
  const ArmSizes sizes = sizesOf(test::withForces(sampleArm(), 1.0 / 80.0));
  EXPECT_NEAR(sizes.of(ArmSize::kTorque), 1.0, 1e-3);
}

TEST(ArmSizes, OfAnArmWithoutCordsAreItsWeights) {
  ArmModel arm = sampleArm();
  arm.muscles.clear();
  const ArmSizes sizes = sizesOf(arm);
  EXPECT_NEAR(sizes.force, 1.0, 1e-3);
  EXPECT_EQ(sizes.length, 1.0);  // nothing says
}

TEST(ArmSizes, CarryWhatEffectsState) {
  const ArmModel strong = test::withForces(sampleArm(), 80.0);
  const ArmSizes sizes = sizesOf(strong), plain = sizesOf(sampleArm());
  EXPECT_NEAR(sizes.length, plain.length, 1e-12);
  EXPECT_NEAR(sizes.of(ArmSize::kTorque), 80.0 * plain.of(ArmSize::kTorque), 1e-9);
  EXPECT_NEAR(sizes.of(ArmSize::kCompliance), plain.of(ArmSize::kCompliance) / 80.0, 1e-12);
  const ArmEffect& spring = *findArmEffect("passive-joint-torque");
  EXPECT_NEAR(onArm(spring.parameters[0], sizes).scale, 80.0 * onArm(spring.parameters[0], plain).scale, 1e-9);
  // A file may hold what such an arm may have, and no more.
  Extension stiff = makeExtension(spring, "elbow", {3000.0});
  EXPECT_EQ(checkExtension(stiff, strong), "");
  EXPECT_NE(checkExtension(stiff, sampleArm()).find("expected a number in [-50"), std::string::npos);
  stiff = makeExtension(spring, "elbow", {300000.0});
  EXPECT_NE(checkExtension(stiff, strong).find("expected a number in [-4"), std::string::npos);
}

}  // namespace
}  // namespace simgap
