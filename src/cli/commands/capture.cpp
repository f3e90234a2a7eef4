#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "cli/inputs.h"
#include "cli/live_capture.h"
#include "simgap/capture/capture_run.h"
#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/progress.h"
#include "simgap/report/capture/capture_report.h"

namespace simgap::commands::capture {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::filesystem::path rig, left, right, timestamps, shafts;
  std::string live;  ///< "0,2": cameras that run
  std::vector<std::filesystem::path> cameras;
  std::optional<double> rate, max_scale_error, duration;
  double max_camera_lag = 2e-3;
  std::vector<std::size_t> overlays;
  bool skip_unreadable = false;
  CaptureRunOptions run;
};

FrameTimes times(const Options& options, Session& session) {
  if (options.timestamps.empty()) return {{}, *options.rate, 0.0};
  const std::string content = session.take("timestamps", options.timestamps);
  return readTimes(CsvTable::parse(content, options.timestamps.string(), options.table.csv()), options.max_camera_lag);
}

void processAll(CaptureRun& run, ImagePairs& pairs, bool quiet) {
  Progress progress("capture: pair", pairs.size().value_or(0), quiet);
  while (pairs.next()) {
    run.add(pairs);
    progress.update(pairs.frame() + 1);
    stopIfInterrupted();
  }
}

void checkOptions(const Options& options) {
  if (options.live.empty()) {
    if (options.left.empty() || options.right.empty()) {
      throw ConfigError("capture needs images: either --left and --right, or --camera LEFT,RIGHT");
    }
    if (options.duration) throw ConfigError("found --duration-s without --camera, which is what it ends");
    if (options.timestamps.empty() == !options.rate) {
      throw ConfigError("capture needs the time of every pair: either --timestamps CSV or --rate HZ");
    }
    return;
  }
  const auto refuse = [](bool given, const char* option) {
    if (given) throw ConfigError(fmt::format("found {} with --camera, whose images are taken as they come", option));
  };
  refuse(!options.left.empty(), "--left");
  refuse(!options.right.empty(), "--right");
  refuse(!options.timestamps.empty(), "--timestamps");
  refuse(!options.shafts.empty(), "--shafts");
  refuse(options.skip_unreadable, "--skip-unreadable");
}

/// Warnings, files and table. \returns whether the user's criterion was met.
ExitCode deliver(const Options& options, Session& session, const CaptureRun& capture, const CaptureResult& result) {
  for (const std::string& name : result.skipped) spdlog::warn("left out: {}", name);
  for (const std::size_t number : result.missing_overlays) spdlog::warn("--overlay {}: there is no such pair", number);
  for (const GeometryFinding& doubt : result.doubts) spdlog::warn("the geometry is in doubt: {}", doubt.sentence);
  if (result.poses_outside_log > 0) {
    spdlog::warn("{} steady poses lie outside the shaft log and were left out", result.poses_outside_log);
  }
  capture.write(session.directory(), result);
  const CaptureStatistics& statistics = capture.statistics();
  session.finish(toJson(result, statistics), terminalTable(result, statistics), "done", posesOf(result));
  const bool scale_failed =
      options.max_scale_error && std::abs(statistics.scaleErrorPercent()) > *options.max_scale_error;
  return scale_failed ? ExitCode::kCriterionFailed : ExitCode::kDone;
}

/// LEFT,RIGHT.
LiveCameras openCameras(const Options& options) {
  const std::size_t comma = options.live.find(',');
  if (comma == std::string::npos || comma == 0 || comma + 1 == options.live.size()) {
    throw ConfigError(fmt::format("--camera: found '{}', expected LEFT,RIGHT, as in 0,2", options.live));
  }
  return LiveCameras(options.live.substr(0, comma), options.live.substr(comma + 1), options.rate);
}

ExitCode runLive(const Options& options, Session& session, const StereoCameras& stereo, const TargetSet& targets,
                 const Rig& rig) {
  LiveCameras cameras = openCameras(options);
  if (options.common.dry_run) {
    session.print(fmt::format("would look for {} targets in the images of {} at {:g} Hz; nothing was written\n",
                              targets.targets.size(), options.live, cameras.rate()));
    return ExitCode::kDone;
  }
  CaptureRunOptions run_options = options.run;
  run_options.overlays.insert(options.overlays.begin(), options.overlays.end());
  session.begin(options.common.seed.value_or(0));  // a directory that is in use is found out before the recording
  CaptureRun capture(stereo, targets, rig, {{}, cameras.rate(), 0.0}, run_options);
  LiveFigures live = followCameras(capture, cameras, options.duration, options.common.quiet);
  CaptureResult result = capture.finish({});
  result.live = std::move(live);
  return deliver(options, session, capture, result);
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  checkOptions(options);
  Session session("capture", options.common, argv);
  const YamlNode root = YamlNode::parse(session.read("rig", options.rig).content, options.rig.string());
  const auto files = rigFiles(root);
  const auto beside = [&](const std::string& name) { return options.rig.parent_path() / name; };
  const std::filesystem::path targets_file = beside(files[1]);
  const TargetSet targets =
      readTargets(YamlNode::parse(session.read("targets", targets_file).content, targets_file.string()));
  const Rig rig = readRig(root, targets);
  const StereoCameras cameras = readCameraFiles(session, options.cameras, beside(files[0])).cameras;
  if (!options.live.empty()) return runLive(options, session, cameras, targets, rig);
  const FrameTimes frame_times = times(options, session);
  std::optional<ShaftLog> shafts;
  if (!options.shafts.empty()) {
    const std::string content = session.take("shafts", options.shafts);
    shafts = readShaftLog(CsvTable::parse(content, options.shafts.string(), options.table.csv()));
  }
  ImagePairs pairs(openImages(options.left), openImages(options.right), options.skip_unreadable);
  if (options.common.dry_run) {
    session.print(fmt::format("would look for {} targets in {} pairs; nothing was written\n", targets.targets.size(),
                              pairs.size() ? std::to_string(*pairs.size()) : "some"));
    return ExitCode::kDone;
  }
  CaptureRunOptions run_options = options.run;
  run_options.overlays.insert(options.overlays.begin(), options.overlays.end());
  CaptureRun capture(cameras, targets, rig, frame_times, run_options, std::move(shafts));
  processAll(capture, pairs, options.common.quiet);
  const CaptureResult result = capture.finish(pairs.skipped());

  session.begin(options.common.seed.value_or(0));
  return deliver(options, session, capture, result);
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("RIG", options->rig, "stereo rig: cameras, targets, joints (YAML)")->required();
  app.add_option("--left", options->left, "images of the left camera: a folder or a video");
  app.add_option("--right", options->right, "images of the right camera");
  app.add_option("--camera", options->live,
                 "instead, cameras that run: numbers or paths of V4L2 devices (0,2), or videos played at their rate")
      ->type_name("LEFT,RIGHT");
  app.add_option("--duration-s", options->duration, "end with --camera after so long; Ctrl-C ends at any time [s]")
      ->check(positiveNumber());
  addCamerasOption(app, options->cameras);
  app.add_option("--timestamps", options->timestamps, "time of every pair (CSV: time_s, or left_time_s, right_time_s)");
  app.add_option("--rate", options->rate, "or so many pairs a second; of --camera: to ask for [Hz]")
      ->check(positiveNumber());
  app.add_option("--shafts", options->shafts, "shaft angles over time, for poses.csv (CSV: time_s, shaft_*_rad)");
  app.add_option("--overlay", options->overlays, "draw what was found into pair N (a PNG); may be repeated")
      ->allow_extra_args(false);
  app.add_option("--threshold", options->run.capture.blobs.threshold, "grey value above which a pixel may be a marker")
      ->check(CLI::Range(1, 254));
  app.add_option("--epipolar-gate", options->run.capture.epipolar_gate,
                 "largest epipolar error of a pair of blobs [px]")
      ->check(positiveNumber());
  app.add_option("--steady-duration", options->run.steady.duration, "a rest is at least this long [s]")
      ->check(positiveNumber());
  app.add_option("--steady-speed", options->run.steady.max_speed, "and no joint faster than this [rad/s]")
      ->check(positiveNumber());
  app.add_option("--max-camera-lag", options->max_camera_lag, "refuse pairs whose cameras are further apart [s]")
      ->check(positiveNumber());
  app.add_option("--max-shaft-lag", options->run.max_shaft_lag,
                 "refuse joints that move later than this after the shafts [s]")
      ->check(positiveNumber());
  app.add_option("--max-scale-error", options->max_scale_error,
                 "exit 1 when distances between markers are off by more [%]")
      ->check(positiveNumber());
  app.add_flag("--skip-unreadable", options->skip_unreadable, "go on behind images that cannot be read");
  app.add_flag("--partial", options->run.partial, "go on when a target is never found");
  options->table.add(app);
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"capture", "stereo images of marker targets to joint angles and the poses calibrate reads",
                    "  simgap capture data/capture/rig.yaml --left data/capture/left \\\n"
                    "    --right data/capture/right --timestamps data/capture/timestamps.csv \\\n"
                    "    --shafts data/capture/shafts.csv --overlay 0 -o runs/capture",
                    define};

}  // namespace simgap::commands::capture
