#include <fmt/format.h>

#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/report/capture/capture_rig_report.h"

namespace simgap::commands::calibrate_joints {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::filesystem::path rig, frames;
  std::vector<std::filesystem::path> cameras;
  std::string zero;
  JointCalibrationOptions calibration;
};

/// "10:40" to frames 10 … 40.
void parseZero(const std::string& text, JointCalibrationOptions& options) {
  if (text.empty()) return;
  int read = 0;
  const bool good = std::sscanf(text.c_str(), "%ld:%ld%n", &options.zero_first, &options.zero_last, &read) == 2 &&
                    read == static_cast<int>(text.size()) && options.zero_first >= 0 &&
                    options.zero_last >= options.zero_first;
  if (!good) throw ConfigError(fmt::format("--zero: found '{}', expected FIRST:LAST frame as in 0:30", text));
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  JointCalibrationOptions calibration = options.calibration;
  parseZero(options.zero, calibration);
  Session session("calibrate-joints", options.common, argv);
  const YamlNode root = YamlNode::parse(session.read("rig", options.rig).content, options.rig.string());
  const auto files = rigFiles(root);
  const std::filesystem::path targets_file = options.rig.parent_path() / files[1];
  const TargetSet targets =
      readTargets(YamlNode::parse(session.read("targets", targets_file).content, targets_file.string()));
  Rig rig = readRig(root, targets);
  const CamerasInput cameras = readCameraFiles(session, options.cameras, options.rig.parent_path() / files[0]);
  const Input& frames = session.read("frames", options.frames);
  const auto motion = readMotion(CsvTable::parse(frames.content, frames.file.string(), options.table.csv()), targets);
  const RigCalibration result = calibrateRig(rig, targets, motion, calibration);
  if (options.common.dry_run) {
    session.print(fmt::format("{}nothing was written\n", terminalTable(result)));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  // A rig of its own: capture runs on it as it stands.
  rig.stereo_file = "stereo.yaml";
  rig.targets_file = "targets.yaml";
  for (std::size_t j = 0; j < rig.joints.size(); ++j) rig.joints[j].zero = result.zeros[j];
  session.directory().write("stereo.yaml", cameras.yaml);
  session.directory().write(
      "targets.yaml", writeTargets(result.targets, {"markers in the frames of the bones: simgap calibrate-joints"}));
  session.directory().write("rig.yaml", writeRig(rig, result.targets));
  session.finish(toJson(result), terminalTable(result));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  const auto positive = positiveNumber();
  app.add_option("RIG", options->rig, "the rig the motion was captured with (YAML)")->required();
  app.add_option("--frames", options->frames, "frames.csv of a capture that moves all joints")->required();
  addCamerasOption(app, options->cameras);
  app.add_option("--zero", options->zero, "FIRST:LAST frame of the zero pose, in which all bones are parallel");
  app.add_option("--max-sd", options->calibration.max_centre_sd, "refuse a centre that is known worse [m]")
      ->check(positive);
  app.add_option("--min-range", options->calibration.min_range, "refuse a motion that spans less [rad]")
      ->check(positive);
  options->table.add(app);
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"calibrate-joints", "from a motion: centres and axes of joints, markers in bone frames",
                    "  simgap capture data/capture/rig.yaml --left data/capture/left \\\n"
                    "    --right data/capture/right --rate 60 -o runs/motion\n"
                    "  simgap calibrate-joints data/capture/rig.yaml \\\n"
                    "    --frames runs/motion/frames.csv --zero 0:10 -o runs/joints\n"
                    "  simgap capture runs/joints/rig.yaml --left data/capture/left \\\n"
                    "    --right data/capture/right --rate 60 -o runs/capture",
                    define};

}  // namespace simgap::commands::calibrate_joints
