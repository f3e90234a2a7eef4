// Causes hidden in poses of a torso of 22 muscles (tests/bench/make_hidden_torso.py, statics by an independent
// minimiser).
#include <gtest/gtest.h>

#include "simgap/core/csv.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/replay.h"
#include "support/files.h"

namespace simgap {
namespace {

/// Asks for the whole catalogue.
Diagnosis diagnoseTorso(const std::string& poses) {
  const ArmModel model = readArm(YamlNode::load(test::sourceFile("data/torso/arm.yaml")));
  const PoseSet set = readPosesFor(model, CsvTable::load(test::sourceFile("tests/reality/torso/" + poses)));
  const CalibrationConfig config =
      CalibrationConfig::read(YamlNode::load(test::sourceFile("configs/calibrate_arm.yaml")));
  return diagnosePoses(model, set, config.parameters, config.noise, {}, [](const std::string&, double) {}).diagnosis;
}

TEST(SlowTorsoCauses, NothingHiddenIsSilent) {
  const Diagnosis diagnosis = diagnoseTorso("hidden_none.csv");
  EXPECT_EQ(diagnosis.verdict, DiagnosisVerdict::kNothingFound) << diagnosis.sentence;
}

TEST(SlowTorsoCauses, FrictionOfTheBicepsLineAmongTheWholeCatalogue) {
  const Diagnosis diagnosis = diagnoseTorso("hidden_pulley.csv");
  ASSERT_EQ(diagnosis.causes.size(), 1u) << diagnosis.sentence;
  EXPECT_EQ(diagnosis.causes[0].effect, "pulley-friction");
  EXPECT_EQ(diagnosis.causes[0].target, "r_biceps");
  EXPECT_LE(diagnosis.causes[0].parameters[0].lower95, 0.3);
  EXPECT_GE(diagnosis.causes[0].parameters[0].upper95, 0.3);
}

}  // namespace
}  // namespace simgap
