// Writes measured data with one cause hidden in them, from the simulators of tests/reality:
//   make_hidden_data EFFECT DIRECTORY [SEED] [RIG]      log.csv, or arm.yaml and poses.csv, or motions
// RIG: prescribed (default) drives a clean motion; servo is a controlled drive that stands still, with an encoder only
// (with bench.yaml where it needs one; what to ask is printed); forearm and reference-arm move: arm.yaml, motions that
// select and that judge (EFFECT "none" and "drag", which no catalogue has, too).
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "reality/drive_draws.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"
#include "reality/pose_draws.h"
#include "reality/servo_draws.h"
#include "reality/spring_rig.h"
#include "support/motion_draws.h"

namespace {

using namespace simgap::reality;

const std::map<std::string, void (*)(PamTruth&)> kPam = {
    {"tendon-compliance", [](PamTruth& t) { t.tendon = 20000.0; }},
    {"pressure-threshold", [](PamTruth& t) { t.bladder = 2e4; }},
    {"pressure-bias", [](PamTruth& t) { t.sensor_offset = -2e4; }},
    {"contraction-damping", [](PamTruth& t) { t.drag = 12.0; }},
    {"contraction-hysteresis", [](PamTruth& t) { t.braid_friction = 3e-5; }},
    {"end-effect", [](PamTruth& t) { t.ends = 0.2; }},
    {"wall-stiffness", [](PamTruth& t) { t.wall = 400.0; }},
    {"muscle-creep", [](PamTruth& t) { t.creep = 0.08; }},
    {"force-bias", [](PamTruth& t) { t.force_offset = 15.0; }}};

const std::map<std::string, void (*)(SpringTruth&)> kSpring = {
    {"spring-softening", [](SpringTruth& t) { t.curve = rubberCurve(0.05); }},
    {"spring-hardening", [](SpringTruth& t) { t.curve = ropeCurve(0.05); }},
    {"spring-direction",
     [](SpringTruth& t) {
       t.curve = {{-1.0, -210.0}, {0.0, 0.0}, {1.0, 150.0}};
     }},
    {"spring-slack", [](SpringTruth& t) { t.pulls_only = true; }},
    {"damping-nonlinearity", [](SpringTruth& t) { t.sliding = 0.15; }},
    {"spring-creep", [](SpringTruth& t) { t.creep_stiffness = 60.0; }},
    {"spring-hysteresis", [](SpringTruth& t) { t.friction = 0.6; }}};

/// data/logs/shock-cord.csv.gz: it hangs loose below 30 mm, and a fifth of its stiffness creeps.
std::string shockCord(std::uint64_t seed) {
  SpringTruth cord;
  cord.creep_stiffness = 40.0, cord.creep_decades = 2.0;
  cord.pulls_only = true, cord.slack_below = 0.03;
  SpringDesign design{.sessions = 4, .rate = 25.0, .low = 0.0, .high = 0.12, .encoder_step = 1e-4, .seed = seed};
  design.spikes = 2;
  return recordSpring(cord, design).csv();
}

const std::map<std::string, void (*)(MotorTruth&)> kMotor = {
    {"brush-drop", [](MotorTruth& t) { t.brush_drop = 0.6; }},
    {"winding-heating", [](MotorTruth& t) { t.heating = 0.2; }},
    {"voltage-bias", [](MotorTruth& t) { t.current_offset = 0.2; }},
    {"load-dependent-efficiency", [](MotorTruth& t) { t.load_loss = 0.25; }},
    {"gearbox-ripple", [](MotorTruth& t) { t.ripple = 0.0015; }},
    {"backlash", [](MotorTruth& t) { t.play = 4.0; }}};

/// Sizes at which these show; the draws of the others do.
const std::map<std::string, void (*)(DriveSecret&)> kDrive = {
    {"presliding-hysteresis", [](DriveSecret& s) { s.bristle_travel = 1.0; }},
    {"torque-bias", [](DriveSecret& s) { s.torque_bias = 1.0; }},
    {"channel-delay", [](DriveSecret& s) { s.delay = 0.06; }}};

std::string driveLog(const std::string& effect, std::uint64_t seed) {
  const auto sized = kDrive.find(effect);
  const bool drawn = sized == kDrive.end() && std::ranges::find(drawableEffects(), effect) != drawableEffects().end();
  DriveDraw draw = drawn ? drawEffect(effect, seed) : drawNone(seed);
  if (sized != kDrive.end()) sized->second(draw.secret);
  const DriveRecord record = recordDrive(draw.rig, draw.secret);
  return effect == "transmission-compliance" ? csvWithMotorAngle(record, draw.rig.ratio, 0.006) : record.csv();
}

std::string logOf(const std::string& effect, std::uint64_t seed) {
  if (const auto muscle = kPam.find(effect); muscle != kPam.end()) {
    PamTruth truth;
    muscle->second(truth);
    return recordPam(truth, {.seed = seed}).csv();
  }
  if (const auto spring = kSpring.find(effect); spring != kSpring.end()) {
    SpringTruth truth;
    spring->second(truth);
    return recordSpring(truth, {.seed = seed}).csv();
  }
  if (effect == "shock-cord") return shockCord(seed);
  if (const auto motor = kMotor.find(effect); motor != kMotor.end()) {
    MotorTruth truth;
    motor->second(truth);
    MotorDesign design{.seconds = 10.0, .sessions = 3, .current_noise = 0.02, .velocity_noise = 0.2, .seed = seed};
    if (effect == "gearbox-ripple" || effect == "backlash") design.voltage = 3.0;
    return simulateMotor(truth, design).csv();
  }
  return driveLog(effect, seed);
}

/// A log of a position-controlled drive, its bench, and how to ask.
void writeServoLog(const std::string& effect, std::uint64_t seed, const std::filesystem::path& directory) {
  const bool hidden = std::ranges::find(servoEffects(), effect) != servoEffects().end();
  const bool outside = std::ranges::find(servoOutsideKinds(), effect) != servoOutsideKinds().end();
  const ServoDraw draw = hidden    ? drawServoEffect(effect, seed)
                         : outside ? drawServoOutside(effect, seed)
                                   : drawServoNone(seed);
  std::ofstream(directory / "log.csv") << recordServo(draw.rig, draw.secret).csv();
  if (const std::string bench = benchYaml(draw.rig); !bench.empty()) std::ofstream(directory / "bench.yaml") << bench;
  std::string options;
  for (const std::string& option : diagnoseOptions(draw.rig)) options += " " + option;
  std::printf("simgap diagnose %s --log log.csv%s   # hidden: %s %.4g\n", draw.law.c_str(), options.c_str(),
              draw.effects[0].c_str(), draw.magnitude);
}

/// Motions of one set, and the set.
void writeMotions(const simgap::test::HiddenMotionCase& hidden, simgap::test::MotionArm arm, std::uint64_t first,
                  std::size_t count, const std::filesystem::path& directory, const std::string& set) {
  std::filesystem::create_directories(directory / set);
  std::string list = "format: simgap/motions/1\nmotions:\n";
  for (std::size_t i = 0; i < count; ++i) {
    const MotionLog log =
        recordMotion(hidden.drawn.truth, simgap::test::drawSetpoints(arm, first + i), hidden.drawn.rig, first + i);
    const std::string name = set.substr(0, 1) + std::to_string(i + 1);
    std::ofstream(directory / set / (name + "_muscles.csv")) << musclesCsv(log);
    std::ofstream(directory / set / (name + "_joints.csv")) << jointsCsv(log, hidden.drawn.truth.arm);
    list += "  - {name: " + name + ", muscles: " + name + "_muscles.csv, joints: " + name + "_joints.csv}\n";
  }
  std::ofstream(directory / set / "motions.yaml") << list;
}

/// An arm that moves, and how to ask. \returns an exit code
int writeMovingArm(const std::string& effect, std::uint64_t seed, simgap::test::MotionArm arm,
                   const std::filesystem::path& directory) {
  const simgap::test::MotionTruth* truth = simgap::test::findMotionTruth(effect == "none" ? "" : effect);
  if (truth == nullptr) {
    std::fprintf(stderr, "%s: found no such cause of an arm that moves\n", effect.c_str());
    return 2;
  }
  const simgap::test::HiddenMotionCase hidden = simgap::test::drawHidden(arm, seed, *truth);
  std::ofstream(directory / "arm.yaml") << toYaml(hidden.believed.arm, {});
  writeMotions(hidden, arm, simgap::test::firstSelecting(seed), simgap::test::kSelectingMotions, directory,
               "calibration");
  writeMotions(hidden, arm, simgap::test::firstJudging(seed), simgap::test::kJudgingMotions, directory, "validation");
  std::printf(
      "simgap diagnose arm.yaml --motions calibration/motions.yaml --validation-motions validation/motions.yaml   "
      "# hidden: %s %s %.4g\n",
      effect.c_str(), hidden.target.c_str(), hidden.magnitude);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("make_hidden_data EFFECT DIRECTORY [SEED] [prescribed|servo|forearm|reference-arm]\n", stderr);
    return 2;
  }
  const std::string effect = argv[1];
  const std::filesystem::path directory = argv[2];
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  std::filesystem::create_directories(directory);
  const std::string rig = argc > 4 ? argv[4] : "prescribed";
  if (rig == "servo") {
    writeServoLog(effect, seed, directory);
    return 0;
  }
  if (rig == "forearm" || rig == "reference-arm") {
    using enum simgap::test::MotionArm;
    return writeMovingArm(effect, seed, rig == "forearm" ? kForearm : kReferenceArm, directory);
  }
  const std::vector<std::string> of_arms = hiddenEffects();
  if (std::ranges::find(of_arms, effect) == of_arms.end()) {
    std::ofstream(directory / "log.csv") << logOf(effect, seed);
    return 0;
  }
  const PoseDraw draw = drawPoses(seed, {.effect = effect});
  std::ofstream(directory / "arm.yaml") << toYaml(draw.nominal, {});
  std::ofstream(directory / "poses.csv") << posesCsv(draw.nominal, draw.poses);
  return 0;
}
