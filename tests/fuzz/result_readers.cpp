#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "fuzz/readers.h"
#include "simgap/core/error.h"
#include "simgap/decode/decoder.h"
#include "simgap/decode/edf.h"
#include "simgap/exchange/exchange.h"
#include "simgap/fit/actuators/bench_protocol.h"
#include "simgap/fit/dynamics/excitation.h"
#include "simgap/fit/dynamics/robot_free_run.h"
#include "simgap/fit/dynamics/robot_model.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/intervene/logs/log_change.h"
#include "simgap/model/arm/arm_change.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/html/result_page.h"
#include "simgap/report/runs/budget.h"
#include "simgap/report/runs/run_comparison.h"
#include "simgap/simulate/cable_drive_motion.h"
#include "simgap/simulate/exo_joint_motion.h"
#include "simgap/simulate/exo_leg_motion.h"
#include "simgap/simulate/joint_targets.h"
#include "simgap/simulate/motion_inputs.h"
#include "simgap/simulate/motion_schedule.h"
#include "simgap/simulate/possible_commands.h"
#include "simgap/simulate/served_arm.h"
#include "simgap/simulate/simulation.h"

namespace simgap::test {
namespace {

/// JSON as a file that stands in memory.
Json jsonOf(const std::string& bytes) {
  const int descriptor = ::memfd_create("input.json", MFD_CLOEXEC);
  const bool written = ::write(descriptor, bytes.data(), bytes.size()) == std::ssize(bytes);
  const auto file = std::filesystem::path("/proc/self/fd") / std::to_string(descriptor);
  struct Closer {
    int descriptor;
    ~Closer() { ::close(descriptor); }
  } const closer{descriptor};
  if (!written) throw std::bad_alloc();
  return readJson(file);
}

YamlNode yaml(const std::string& bytes) { return YamlNode::parse(bytes, "input.yaml"); }

void readState(std::string bytes) { calibrationStateFromJson(jsonOf(bytes)); }
void readMotionState(std::string bytes) { motionSearchStateFromJson(jsonOf(bytes), 2); }
/// A forearm on a hinge between two muscles.
const ArmModel& forearm() {
  static const ArmModel model = readArm(YamlNode::parse(R"(format: simgap/arm/1
name: rig
gravity_m_s2: [0, 0, -9.81]
bodies:
  - {name: humerus, fixed: true}
  - {name: forearm, parts: [{name: bone, shape: cylinder, radius_m: 0.02, length_m: 0.24, mass_kg: 0.6, position_m: [0, 0, -0.12], axis: [0, 0, 1]}]}
joints:
  - {name: e, type: revolute, parent: humerus, child: forearm, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_rad: -2, upper_limit_rad: 2, coulomb_friction_Nm: 0.02, viscous_friction_Nms: 0.02}
motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.011, torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.002, supply_voltage_V: 12}
gearbox_defaults: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.002, coulomb_friction_Nm: 0.03}
muscles:
  - {name: a, attachments: [{body: humerus, point_m: [0, 0.03, 0.15]}, {body: forearm, point_m: [0, 0.03, -0.05]}], kite_line_length_m: 0.1, shock_cord: {rest_length_m: 0.08, stiffness_N_m: 950, damping_Ns_m: 15}, spindle_radius_m: 0.006}
  - {name: b, attachments: [{body: humerus, point_m: [0, -0.03, 0.15]}, {body: forearm, point_m: [0, -0.03, -0.05]}], kite_line_length_m: 0.1, shock_cord: {rest_length_m: 0.08, stiffness_N_m: 950, damping_Ns_m: 15}, spindle_radius_m: 0.006}
)",
                                                        "forearm.yaml"));
  return model;
}

/// Settings, and the forearm's parameters that they choose.
void readCalibration(std::string bytes) { ParameterSpace(forearm(), CalibrationConfig::read(yaml(bytes)).parameters); }
void readMotionCalibration(std::string bytes) {
  ParameterSpace(forearm(), MotionCalibrationConfig::read(yaml(bytes)).parameters);
}

/// Commands of muscles or of joints, a start for them, and joints measured meanwhile.
void readCommandTable(std::string bytes) {
  const CsvTable table = CsvTable::parse(std::move(bytes), "input.csv");
  const auto tryReading = [](auto&& read) {
    try {
      read();
    } catch (const Error&) {
    }
  };
  tryReading([&] { readMotionStart(table, forearm(), ""); });
  tryReading([&] { readMeasuredJoints(table, forearm(), 0.0, 1.0); });
  tryReading([&] {
    if (hasJointTargets(table, forearm())) readJointTargets(table, forearm(), /*linear=*/true);
  });
  motionEnd(readCommands(table, forearm(), /*linear=*/true), "input.csv", {});
}

void readMovement(std::string bytes) {
  readSchedule(yaml(bytes), forearm(), 100.0, [](const std::string&) {
    Pose pose;
    pose.name = "p";
    pose.shafts = {1.0, 2.0};
    return PoseSet{"poses.csv", {pose}};
  });
}

void readSimulation(std::string bytes) { SimulationOptions::read(yaml(bytes)).rollout.validate(); }

/// Lines of a program that runs the arm; each has its answer.
void serve(std::string bytes) {
  ServedArm arm(forearm(), {.step = 0.002, .controllers = {}});
  for (std::size_t begin = 0, line = 0; begin < bytes.size() && line < 8; ++line) {
    const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
    arm.answer(std::string_view(bytes).substr(begin, end - begin));
    begin = end + 1;
  }
}

/// A run whose result is `result`, and nothing else.
std::filesystem::path runWith(const Json& result) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("simgap-fuzz-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "run.json") << R"({"start": "2026-01-01T00:00:00Z", "inputs": []})";
  std::ofstream(folder / "result.json") << toText(result);
  return folder;
}

/// The page of a result whose tables are not there: what stands in result.json alone.
void readResult(std::string bytes) {
  const Json result = jsonOf(bytes);
  const Json run = {{"argv", Json::array()}, {"version", ""},     {"git_hash", ""},   {"seed", 0},
                    {"start", ""},           {"duration_s", 0.0}, {"status", "done"}, {"inputs", Json::array()}};
  makePage(ResultFiles(runWith(result), run));
}

/// Held against itself, and against a budget that names all kinds of limits.
void compareResult(std::string bytes) {
  static const Budget budget = readBudget(yaml(R"(format: simgap/budget/1
limits:
  - {value: validation.after.0, upper: 2}
  - {parameter: "*", lower: 0, upper: 3, largest_sd_percent: 5}
  - {verdict: [cause-found, nothing-found]}
  - {cause: "*", upper: 5}
)"));
  const auto folder = runWith(jsonOf(bytes));
  guardText(checkBudget(budget, ResultFiles(folder)));
  const RunFigures run = readRun(folder);
  comparisonText(compareRuns({run, run, run}));
}

void readLimits(std::string bytes) {
  static const auto folder = runWith(Json::parse(
      R"({"format": "simgap/fit-friction/1", "parameters": [{"name": "k_a", "value": 1.0, "sd": 0.1, "unit": "A"}]})"));
  const Json guard = checkBudget(readBudget(yaml(bytes)), ResultFiles(folder));
  guardText(guard);
  guardMarkdown(guard);
  guardJunit(guard);
}

/// What was done to an arm, done to the forearm.
void readChange(std::string bytes) {
  ArmModel model = forearm();
  const ArmChanges changes = ArmChanges::read(yaml(bytes), model);
  changes.undoes("payload:forearm");
  withinUncertainty(changes);
  changes.apply(model);
}

void readCandidates(std::string bytes) { CandidateList::read(yaml(bytes)); }

/// Of a bare hinge.
void readMotionCandidates(std::string bytes) {
  ArmModel hinge;
  hinge.joints.resize(1);
  MotionCandidateList::read(yaml(bytes), hinge);
}

void readCovarianceOf(std::string bytes) { readCovariance(CsvTable::parse(std::move(bytes), "covariance.csv")); }

/// What was done to a bench, done to a drive on a pendulum, before and after it.
void readLogChange(std::string bytes) {
  const LogChanges changes = LogChanges::read(yaml(bytes));
  withinUncertainty(changes);
  for (const bool recorded : {false, true}) {
    LogSetting setting;
    setting.bench.load = BenchLoad::kPendulum;
    changes.apply(setting, recorded);
  }
}

void readLogCandidates(std::string bytes) { LogCandidateList::read(yaml(bytes)); }

void readRobot(std::string bytes) { readRobotModel(yaml(bytes)); }

const ArmModel& robotOfOneHinge() {
  static const ArmModel robot =
      readUrdf(
          "<robot name='r'><link name='base'/><link name='link1'><inertial><mass value='1'/><inertia ixx='1' iyy='1' "
          "izz='1' "
          "ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='j1' type='revolute'><parent link='base'/><child "
          "link='link1'/><axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>",
          "robot.urdf")
          .model;
  return robot;
}

void readExcitationLimits(std::string bytes) { ExcitationLimits::read(yaml(bytes), robotOfOneHinge()); }
void readGains(std::string bytes) { readJointGains(yaml(bytes), robotModelOf(robotOfOneHinge())); }

void readDriveLimits(std::string bytes) { DriveLimits::read(yaml(bytes), nullptr); }
void readEegDecoder(std::string bytes) { readDecoder(yaml(bytes)); }

/// What is read is decoded, by a decoder of its own channels and rate.
void readHead(std::string bytes) {
  const EegRecording recording = readEeg(CsvTable::parse(std::move(bytes), "input.csv"), {});
  const auto channels = static_cast<Eigen::Index>(recording.channels.size());
  Decoder decoder{{}, recording.channels, recording.rate, Eigen::MatrixXd::Identity(channels, channels), 0.0, 1.0};
  decoder.settings.window = 0.25;
  if (channels < 100) decode(decoder, recording);
}

/// A joint, its commands and some ticks of it; a muscle that it names is the sample's.
void readJoint(std::string bytes) {
  const ExoJoint joint = readExoJoint(yaml(bytes), [](const std::string&) {
    return readFittedModel(
        yaml("format: simgap/pam/1\nlaw: spring\nparameters: {a: {value: 0.01, unit: m2}, b: {value: "
             "-0.02, unit: m2}, c: {value: 0.006, unit: m2}, k: {value: 4e4, unit: N}}\n"));
  });
  const ExoJointCommands commands{true, {{}, {0.0, 0.01}, Eigen::MatrixXd::Constant(2, 2, 5.0), false}};
  playExoJoint(joint, commands, 0.01, {.step = 0.01, .settle = 0.0});
}

void readJointCommands(std::string bytes) {
  ExoJoint joint;
  joint.rate = 100.0, joint.supply = 6e5;
  if (bytes.starts_with("format")) {
    readExoJointSchedule(joint, yaml(bytes));
  } else {
    readExoJointCommands(joint, CsvTable::parse(std::move(bytes), "input.csv"), false);
  }
}

/// A leg, and some ticks of it.
void readLeg(std::string bytes) {
  const ExoLeg leg = readExoLeg(yaml(bytes));
  studyExoLeg(leg, {{0.0, 0.01}, {true, true}}, 0.01, 0.005);
}

void readSwitch(std::string bytes) { readLegSwitch(CsvTable::parse(std::move(bytes), "input.csv")); }

/// A drive with a cable whose friction files are all one, and some ticks of it.
void readDrive(std::string bytes) {
  const CableDrive drive = readCableDrive(yaml(bytes), [](const std::string&) {
    return readFittedModel(
        yaml("format: simgap/friction/1\nlaw: coulomb\nparameters: {k_a: {value: 1.3, unit: Nm_A}, tau_c: {value: 1, "
             "unit: Nm}, k_v: {value: 0.01, unit: Nms_rad}}\n"));
  });
  const CableDriveCommands commands{false, {{}, {0.0, 0.01}, Eigen::MatrixXd::Constant(2, 2, 0.5), false}};
  playCableDrive(drive, drive.compensations.back(), commands, 0.01, {.step = 0.01, .settle = 0.0});
}

void readDriveCommands(std::string bytes) {
  if (bytes.starts_with("format")) {
    readCableDriveSchedule(yaml(bytes), 100.0);
  } else {
    readCableDriveCommands(CsvTable::parse(std::move(bytes), "input.csv"), false);
  }
}

void readRecorder(std::string bytes) {
  if (isEdf(bytes)) readEdf(bytes, "input.edf", {});
}

constexpr std::array kReaders = {
    Reader{"state", readState},
    Reader{"calibration", readCalibration},
    Reader{"result", readResult},
    Reader{"compared", compareResult},
    Reader{"budget", readLimits},
    Reader{"motion_state", readMotionState},
    Reader{"motion_calibration", readMotionCalibration},
    Reader{"commands", readCommandTable},
    Reader{"schedule", readMovement},
    Reader{"simulation", readSimulation},
    Reader{"serve", serve},
    Reader{"change", readChange},
    Reader{"candidates", readCandidates},
    Reader{"motion_candidates", readMotionCandidates},
    Reader{"covariance", readCovarianceOf},
    Reader{"log_change", readLogChange},
    Reader{"log_candidates", readLogCandidates},
    Reader{"robot", readRobot},
    Reader{"excitation", readExcitationLimits},
    Reader{"joint_gains", readGains},
    Reader{"drive_limits", readDriveLimits},
    Reader{"decoder", readEegDecoder},
    Reader{"eeg", readHead},
    Reader{"edf", readRecorder},
    Reader{"exo_joint", readJoint},
    Reader{"exo_commands", readJointCommands},
    Reader{"exo_leg", readLeg},
    Reader{"leg_switch", readSwitch},
    Reader{"cable_drive", readDrive},
    Reader{"drive_commands", readDriveCommands},
};

}  // namespace

std::span<const Reader> resultReaders() { return kReaders; }

}  // namespace simgap::test
