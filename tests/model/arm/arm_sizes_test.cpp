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
  EXPECT_NEAR(sizes.mass, 1.0, 1e-3);
}

TEST(ArmSizes, OfASmallerArmAreTheSampleArms) {
  const ArmSizes sizes = sizesOf(test::withForces(sampleArm(), 1.0 / 80.0));
  EXPECT_NEAR(sizes.of(ArmSize::kTorque), 1.0, 1e-3);
  EXPECT_NEAR(sizes.mass, 1.0, 1e-3);
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
  const ArmEffect& payload = *findArmEffect("payload");
  const ArmEffectParameter mass = onArm(payload.parameters[0], sizes), distance = onArm(payload.parameters[1], sizes);
  EXPECT_NEAR(mass.scale, 80.0 * onArm(payload.parameters[0], plain).scale, 1e-9);
  EXPECT_EQ(distance.scale, onArm(payload.parameters[1], plain).scale);
  // A file may hold what such an arm may carry, and no more.
  Extension load = makeExtension(payload, "forearm", {300.0, 0.2});
  EXPECT_EQ(checkExtension(load, strong), "");
  EXPECT_NE(checkExtension(load, sampleArm()).find("expected a number in [-2, 20]"), std::string::npos);
  load = makeExtension(payload, "forearm", {3000.0, 0.2});
  EXPECT_NE(checkExtension(load, strong).find("expected a number in [-160"), std::string::npos);
}

}  // namespace
}  // namespace simgap
