// Causes hidden in poses of a routed finger (tests/bench/make_hidden_finger.py, which shares no code with the models):
// found by their name and line, and silence where nothing is hidden.
#include <gtest/gtest.h>

#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/replay.h"
#include "support/files.h"

namespace simgap {
namespace {

Diagnosis diagnoseFinger(const std::string& arm, const std::string& poses, std::vector<std::string> effects) {
  const ArmModel model = readArm(YamlNode::load(test::sourceFile(arm)));
  const PoseSet set = readPosesFor(model, CsvTable::load(test::sourceFile("tests/reality/finger/" + poses)));
  const CalibrationConfig config =
      CalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_finger.yaml")));
  PoseDiagnosisOptions options;
  options.effects = std::move(effects);
  return diagnosePoses(model, set, config.parameters, config.noise, options, [](const std::string&, double) {})
      .diagnosis;
}

/// What acts on lines; the whole catalogue has others that 50 poses hardly tell from them
/// (docs/studies/diagnose-poses.md).
const std::vector<std::string> kOfLines = {"pulley-friction", "ligament-rest-length", "muscle-wrap", "line-elasticity",
                                           "cord-hardening"};

void expectAlone(const Diagnosis& diagnosis, const std::string& effect, const std::string& target) {
  ASSERT_EQ(diagnosis.causes.size(), 1u) << diagnosis.sentence;
  EXPECT_EQ(diagnosis.causes[0].effect, effect) << diagnosis.sentence;
  EXPECT_EQ(diagnosis.causes[0].target, target) << diagnosis.sentence;
}

void expectWithin(const Diagnosis& diagnosis, double hidden) {
  const Estimate& found = diagnosis.causes[0].parameters[0];
  EXPECT_LE(found.lower95, hidden);
  EXPECT_GE(found.upper95, hidden);
}

TEST(SlowFingerCauses, NothingHiddenIsSilent) {
  const Diagnosis diagnosis = diagnoseFinger("data/finger/arm.yaml", "hidden_none.csv", {});
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNothingFound) << diagnosis.sentence;
}

TEST(SlowFingerCauses, FrictionOfTheExtensorsLine) {
  const Diagnosis diagnosis = diagnoseFinger("data/finger/arm.yaml", "hidden_pulley.csv", kOfLines);
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kCauseFound) << diagnosis.sentence;
  expectAlone(diagnosis, "pulley-friction", "extensor");
  expectWithin(diagnosis, 0.25);
}

/// One pose has no rest of the model near it once the friction is in; it must not make look-alikes of what is left.
TEST(SlowFingerCauses, FrictionAmongTheWholeCatalogue) {
  const Diagnosis diagnosis = diagnoseFinger("data/finger/arm.yaml", "hidden_pulley.csv", {});
  expectAlone(diagnosis, "pulley-friction", "extensor");
  expectWithin(diagnosis, 0.25);
}

TEST(SlowFingerCauses, ALongerLigament) {
  const Diagnosis diagnosis = diagnoseFinger("data/finger/arm.yaml", "hidden_ligament.csv", kOfLines);
  expectAlone(diagnosis, "ligament-rest-length", "collateral");
  expectWithin(diagnosis, 0.005);
}

TEST(SlowFingerCauses, ALigamentThatLiesOnAJoint) {
  expectAlone(diagnoseFinger("tests/reality/finger/straight_band.yaml", "hidden_wrap.csv", kOfLines), "muscle-wrap",
              "dip_band");
}

}  // namespace
}  // namespace simgap
