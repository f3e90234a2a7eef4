#include "real/real_logs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "support/files.h"
#include "support/process.h"

namespace simgap::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words mapped(const std::vector<std::pair<std::string, std::string>>& names) {
  Words words;
  for (const auto& [name, column] : names) words.insert(words.end(), {"--map", name + "=" + column});
  return words;
}

Words ur(int joint) {
  return mapped({{"position_rad", fmt::format("q{}_rad", joint)},
                 {"motor_velocity_rad_s", fmt::format("qd{}_rad_s", joint)},
                 {"motor_current_A", fmt::format("current{}_A", joint)}});
}

std::string pendulum(double mass, double length) {
  return fmt::format("load: pendulum\nmass_kg: {}\nlength_m: {}\ninertia_kg_m2: fit\nbandwidth_Hz: 8\n", mass, length);
}

const std::string kFreeJoint = "load: free-axis\ninertia_kg_m2: fit\nbandwidth_Hz: 5\n";
const std::string kPiston = "load: free-axis\nmass_kg: 0.1\nbandwidth_Hz: 3\n";

std::string urArm(double offset) {
  return fmt::format(
      "load: pendulum\nlength_m: 1\nmass_kg: fit\ninertia_kg_m2: fit\nangle_offset_rad: {}\nbandwidth_Hz: 5\n", offset);
}

void addArms(std::vector<RealLog>& logs) {
  logs.push_back({"ur10e-1",
                  "coulomb",
                  "ur10e/jointwise_joint1.csv.gz",
                  kFreeJoint,
                  ur(1),
                  {},
                  {"viscous-nonlinearity", "stribeck"},
                  "friction grows like a root of speed: stribeck beats coulomb by 20 % with v_s at its bound"});
  logs.push_back({"ur10e-2",
                  "coulomb",
                  "ur10e/jointwise_joint2.csv.gz",
                  urArm(1.5708),
                  ur(2),
                  {},
                  {"load-dependence", "load-nonlinearity", "viscous-nonlinearity", "stribeck"},
                  "variant-b beats classic by 24 %: friction grows with the load"});
  logs.push_back({"ur10e-3",
                  "coulomb",
                  "ur10e/jointwise_joint3.csv.gz",
                  urArm(3.1416),
                  ur(3),
                  {},
                  {"load-dependence", "load-nonlinearity", "viscous-nonlinearity", "stribeck"},
                  "variant-b beats classic by 30 %: friction grows with the load"});
  logs.push_back({"ur10e-4",
                  "coulomb",
                  "ur10e/jointwise_joint4.csv.gz",
                  kFreeJoint,
                  ur(4),
                  {"joint-gravity"},
                  {},
                  "a cosine of the angle alone leaves 0.04 A, what the joint's noise is"});
  logs.push_back({"ur10e-all-1",
                  "coulomb",
                  "ur10e/fourier_14harm_noload.csv.gz",
                  kFreeJoint,
                  ur(1),
                  {},
                  {"viscous-nonlinearity", "stribeck"},
                  "all joints move: the others' torques explain 29 to 44 % of what one joint's model leaves"});
}

void addServos(std::vector<RealLog>& logs) {
  const std::string folder = "feetech_sts3215_pendulum/";
  const auto add = [&](const std::string& name, double mass, double length, const std::string& voltage) {
    Words words = mapped({{"session", "run"}, {"motor_voltage_V", voltage}});
    words.emplace_back("--ignore-faults");
    logs.push_back({name,
                    "coulomb",
                    fmt::format("{}mass{:.3f}kg_len{:.0f}mm.csv.gz", folder, mass, 1000.0 * length),
                    pendulum(mass, length),
                    words,
                    {"channel-delay"},
                    {"speed-limit", "load-dependence", "viscous-nonlinearity"},
                    "cross-correlation of voltage and motion: 40 to 51 ms; the speed ends at 4.2 to 4.4 rad/s"});
  };
  add("sts3215-0535", 0.535, 0.1, "reported_pwm_voltage_V");
  add("sts3215-0741", 0.741, 0.15, "reported_pwm_voltage_V");
  add("sts3215-0969", 0.969, 0.1, "reported_pwm_voltage_V");
  add("sts3215-1168", 1.168, 0.1, "reported_pwm_voltage_V");
  add("sts3215-1168-commanded", 1.168, 0.1, "computed_voltage_V");
  logs.back().truth.emplace_back("speed-limit");
  for (const std::string run : {"sin_time_square_kp100", "sin_sin_kp200", "up_and_down_kp400"}) {
    logs.push_back({"xl330-" + run,
                    "coulomb",
                    "bam_xl330/" + run + ".csv.gz",
                    "load: pendulum\nlength_m: 0.1\nmass_kg: fit\nbandwidth_Hz: 8\n",
                    {},
                    {},
                    {"load-dependence", "stribeck", "channel-delay", "viscous-nonlinearity"},
                    "models of these servos have load-dependent Stribeck friction (arXiv 2410.08650)"});
  }
}

void addBenches(std::vector<RealLog>& logs) {
  logs.push_back({"emps",
                  "coulomb",
                  "emps/emps_train.csv.gz",
                  "load: free-axis\nmass_kg: fit\nbandwidth_Hz: 60\n",
                  {},
                  {"viscous-asymmetry"},
                  {},
                  "published: viscous friction by direction, relative force error 4.08 to 3.11 %"});
  const Words tmotor =
      mapped({{"motor_velocity_rad_s", "output_velocity_rad_s"}, {"external_torque_Nm", "measured_output_torque_Nm"}});
  for (const std::string trial : {"trial8_identification", "trial5"}) {
    Words words = tmotor;
    words.emplace_back("--ignore-faults");
    logs.push_back({"tmotor-" + trial,
                    "load-coulomb",
                    "tmotor_ak80_9/loaded_" + trial + ".csv.gz",
                    {},
                    words,
                    {},
                    {"channel-delay"},
                    "no friction law helps; shifting a channel by a row does"});
  }
  for (const std::string side : {"A", "B"}) {
    logs.push_back({"embir-" + side,
                    "stribeck",
                    "embir_actuator_dyno/direct_velocity_friction_" + side + ".csv.gz",
                    {},
                    mapped({{"motor_current_A", "motor1_current_A"},
                            {"motor_velocity_rad_s", "motor1_velocity_rad_s"},
                            {"external_torque_Nm", "shaft_torque_Nm"}}),
                    {},
                    {"inertia", "viscous-nonlinearity"},
                    "the rotor's inertia is between current and torque sensor"});
  }
  for (const std::string ramp : {"spring5_ramp6", "spring1_ramp1", "spring2_ramp2"}) {
    logs.push_back({"sea-" + ramp,
                    "coulomb",
                    "sea_rmd_x8_spring/" + ramp + ".csv.gz",
                    {},
                    mapped({{"motor_current_A", "current_command_A"},
                            {"motor_position_rad", "spring_deflection_rad"},
                            {"external_torque_Nm", "measured_torque_Nm"}}),
                    {},
                    {},
                    "the output is locked: no inertia, no gravity, no delay of 0.2 s"});
  }
  for (const std::string seal : {"napn_1bar", "napn_7bar", "oring_1bar", "oring_7bar"}) {
    logs.push_back({"seal-" + seal,
                    "coulomb",
                    "pneumatic_piston_friction/" + seal + ".csv.gz",
                    kPiston,
                    mapped({{"motor_force_N", "force_N"}}),
                    {"current-bias"},
                    {"presliding-hysteresis", "viscous-nonlinearity", "direction-asymmetry", "viscous-asymmetry"},
                    "50 N per bar on the rod; rubber seals stick and creep"});
  }
  for (const std::string motor : {"1", "2", "3"}) {
    logs.push_back({"robotino-" + motor,
                    "coulomb",
                    "robotino_dc_motor/free_steps_P_controller.csv.gz",
                    "load: free-axis\ninertia_kg_m2: fit\n",
                    mapped({{"motor_velocity_rad_s", "motor" + motor + "_speed_rad_s"},
                            {"motor_current_A", "motor" + motor + "_current_A"}}),
                    {},
                    {},
                    "published: Coulomb and viscous friction, nothing else"});
  }
  logs.push_back({"damper",
                  "coulomb",
                  "friction_damper_backlash/tension_35lb.csv.gz",
                  kPiston,
                  {},
                  {"backlash"},
                  {"presliding-hysteresis"},
                  "built with backlash: the force is zero over 4 to 6 mm after reversals"});
  logs.push_back({"festo-isometric",
                  "pam",
                  "festo_bpa_static/festo_10mm_isometric.csv.gz",
                  {},
                  mapped({{"session", "test"}}),
                  {},
                  {"contraction-hysteresis"},
                  "pressing alone leaves 38.7 N, releasing alone 22.6 N"});
  logs.push_back(
      {"festo-620kPa", "pam", "festo_bpa_static/festo_10mm_620kPa_length_force.csv.gz", {}, {}, {}, {}, "23 rows"});
}

}  // namespace

std::optional<fs::path> realFolder() {
  const char* given = std::getenv("SIMGAP_REAL_DATA");
  const fs::path folder = given != nullptr ? fs::path(given) : sourceFile("../shared/data/real");
  if (!fs::is_directory(folder)) return std::nullopt;
  return folder;
}

std::optional<fs::path> standstillFolder() {
  const auto real = realFolder();
  if (!real || !fs::exists(*real / "../logs/standstill-none-31.csv.gz")) return std::nullopt;
  return *real / "../logs";
}

const std::vector<RealLog>& realLogs() {
  static const std::vector<RealLog> list = [] {
    std::vector<RealLog> logs;
    addBenches(logs);
    addArms(logs);
    addServos(logs);
    return logs;
  }();
  return list;
}

const RealLog& realLog(const std::string& name) {
  const auto found = std::ranges::find(realLogs(), name, &RealLog::name);
  if (found == realLogs().end()) throw std::runtime_error("no such log: " + name);
  return *found;
}

std::string RealAnswer::verdict() const { return error.empty() ? result.at("verdict") : "refused"; }

bool RealAnswer::names(const std::string& effect) const {
  return std::ranges::any_of(named, [&](const auto& group) { return std::ranges::find(group, effect) != group.end(); });
}

const Json* RealAnswer::cause(const std::string& effect) const {
  if (!error.empty()) return nullptr;
  for (const Json& cause : result.at("causes")) {
    if (cause.at("effect") == effect) return &cause;
  }
  return nullptr;
}

std::string RealAnswer::text() const {
  if (!error.empty()) return "refused: " + error;
  std::string causes;
  for (const Json& cause : result.at("causes")) {
    causes += " " + cause.at("effect").get<std::string>();
    const Words rivals = cause.at("ambiguous_with");
    if (!rivals.empty()) causes += fmt::format("~{}", fmt::join(rivals, "~"));
    causes += fmt::format(" ({:.0f} %)", cause.at("gain_heldout_percent").get<double>());
  }
  return verdict() + causes;
}

RealAnswer diagnoseReal(const RealLog& real, const fs::path& log, const fs::path& folder, const std::string& binary) {
  fs::create_directories(folder);
  Words words = {binary, "diagnose", real.law, "--log", log.string(), "-q", "--force", "-o", "d"};
  words.insert(words.end(), real.options.begin(), real.options.end());
  if (!real.bench.empty()) {
    std::ofstream(folder / "bench.yaml") << "format: simgap/bench/1\n" << real.bench;
    words.insert(words.end(), {"--bench", "bench.yaml"});
  }
  const ProcessResult run = runProcess(words, folder);
  RealAnswer answer;
  if (run.exit_code != 0) {
    answer.error = run.err.empty() ? fmt::format("exit code {}, signal {}", run.exit_code, run.signal) : run.err;
    return answer;
  }
  answer.result = Json::parse(readText(folder / "d/result.json"));
  for (const Json& cause : answer.result.at("causes")) {
    answer.named.push_back({cause.at("effect")});
    for (const Json& rival : cause.at("ambiguous_with")) answer.named.back().push_back(rival);
  }
  return answer;
}

}  // namespace simgap::test
