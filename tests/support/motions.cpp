#include "support/motions.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>

namespace simgap::test {

reality::MovingArm movingForearm() {
  reality::MovingArm moving;
  reality::Link link;
  link.joint = reality::Joint::kRevolute;
  link.lower = -2.0;
  link.upper = 2.0;
  link.coulomb = 0.02;
  link.viscous = 0.03;
  link.parts = {{0.02, 0.24, 0.6, {0.0, 0.0, -0.12}, {0.0, 0.0, 1.0}}};
  moving.arm.links = {link};
  for (const double side : {1.0, -1.0}) {
    reality::Muscle muscle;
    muscle.from = {reality::kTorso, {0.0, 0.03 * side, 0.15}};
    muscle.to = {0, {0.0, 0.03 * side, -0.05}};
    muscle.kite_line = 0.10;
    moving.arm.muscles.push_back(muscle);
  }
  moving.drives.resize(2);
  return moving;
}

reality::MovingArm trueForearm() {
  reality::MovingArm moving = movingForearm();
  moving.arm.links[0].viscous *= 1.5;
  moving.arm.links[0].coulomb *= 0.7;
  moving.arm.muscles[0].kite_line += 0.002;
  moving.arm.muscles[1].kite_line -= 0.0015;
  moving.arm.muscles[0].damping *= 1.3;
  moving.arm.muscles[1].damping *= 0.8;
  for (reality::DriveTruth& drive : moving.drives) drive.coulomb *= 1.2;
  return moving;
}

reality::Setpoints forearmSetpoints(int draw) {
  return [draw](double time) {
    const double phase = 0.7 * draw, pulled = 3.0 + 0.3 * std::sin(phase);
    double swing = 0.0;
    if (time >= 0.4) swing = 1.0 * std::sin(2.0 * 3.14159265358979 * (0.5 + 0.1 * draw) * (time - 0.4));
    if (time >= 2.0) swing = draw % 2 ? 1.2 : -1.0;
    return std::vector<double>{pulled + swing, pulled - swing};
  };
}

MotionSet recordMotions(const reality::MovingArm& truth, const ArmModel& model,
                        const std::function<reality::Setpoints(std::uint64_t)>& commands, std::uint64_t first,
                        std::size_t count, const reality::MotionRigOptions& options) {
  std::vector<std::string> muscles(count), joints(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const auto log = reality::recordMotion(truth, commands(first + i), options, first + i);
    muscles[i] = reality::musclesCsv(log);
    joints[i] = reality::jointsCsv(log, truth.arm);
  });
  std::string set = "format: simgap/motions/1\nmotions:\n";
  for (std::size_t i = 0; i < count; ++i) set += fmt::format("  - {{name: m{0}, muscles: m{0}, joints: j{0}}}\n", i);
  return readMotionsFor(model, YamlNode::parse(set, "set.yaml"), "set.yaml", [&](const std::filesystem::path& file) {
    const std::string name = file.string();
    return CsvTable::parse((name[0] == 'm' ? muscles : joints)[std::stoul(name.substr(1))], name);
  });
}

namespace {

void putRecorded(const TemporaryFolder& folder, const std::string& name, int first, int count,
                 const reality::MotionRigOptions& options, const std::function<reality::Setpoints(int)>& commands) {
  const reality::MovingArm truth = trueForearm();
  std::string set = "format: simgap/motions/1\nmotions:\n";
  for (int i = first; i < first + count; ++i) {
    const reality::MotionLog log = reality::recordMotion(truth, commands(i), options, static_cast<std::uint64_t>(i));
    const std::string stem = fmt::format("{}_m{}", name.substr(0, name.find('.')), i);
    folder.put(stem + "_muscles.csv", reality::musclesCsv(log));
    folder.put(stem + "_joints.csv", reality::jointsCsv(log, truth.arm));
    set += fmt::format("  - {{name: m{0}, muscles: {1}_muscles.csv, joints: {1}_joints.csv}}\n", i, stem);
  }
  folder.put(name, set);
}

}  // namespace

void putMotions(const TemporaryFolder& folder, const std::string& name, int first, int count,
                const reality::MotionRigOptions& options) {
  putRecorded(folder, name, first, count, options, forearmSetpoints);
}

void putVoltageMotions(const TemporaryFolder& folder, const std::string& name, int first, int count) {
  reality::MotionRigOptions options;
  options.voltages_from = {3.0, 3.0};
  putRecorded(folder, name, first, count, options, [](int draw) -> reality::Setpoints {
    return [draw](double time) {
      if (time < 0.4) return std::vector<double>{0.0, 0.0};
      const double pulse = (draw % 2 ? 3.0 : 4.0) * std::sin(2.0 * M_PI * (0.8 + 0.2 * draw) * (time - 0.4));
      return std::vector<double>{0.4 + 0.5 * pulse, 0.4 - 0.5 * pulse};
    };
  });
}

void putRests(const TemporaryFolder& folder, const std::string& name) {
  const reality::MovingArm truth = trueForearm();
  std::string text = "pose,shaft_muscle1_rad,shaft_muscle2_rad,joint1_rad\n";
  for (int i = 0; i < 6; ++i) {
    const std::vector<double> shafts = {2.0 + 0.4 * i, 4.0 - 0.3 * i};
    const auto rest = reality::followFromRest(truth.arm, shafts);
    text += fmt::format("p{},{},{},{:.9g}\n", i, shafts[0], shafts[1], rest.configuration[0].angle);
  }
  folder.put(name, text);
}

std::string forearmConfig() {
  return R"(format: simgap/calibration/1
parameters:
  - {pattern: "muscles.*.kite_line_length_m", step: 5.0e-4, prior_sd: 2.0e-3}
  - {pattern: "muscles.*.shock_cord.damping_Ns_m", step: 1, lower: 0.1, upper: 1.0e+3, prior_sd_percent: 30}
  - {pattern: "joints.*.coulomb_friction_Nm", step: 5.0e-3, lower: 1.0e-4, upper: 10, prior_sd_percent: 40}
  - {pattern: "joints.*.viscous_friction_Nms", step: 5.0e-3, lower: 1.0e-4, upper: 10, prior_sd_percent: 40}
  - {pattern: "muscles.*.motor.coulomb_friction_Nm", together: true, step: 2.0e-4, lower: 1.0e-6, upper: 0.1, prior_sd_percent: 30}
)";
}

}  // namespace simgap::test
