#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/parallel_invoke.h>

#include "simgap/capture/camera_files.h"
#include "simgap/capture/image_pairs.h"
#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/progress.h"
#include "simgap/report/capture/camera_calibration_report.h"

namespace simgap::commands::calibrate_cameras {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string left, right, board, corners, image_size;
  std::vector<std::string> scale_bar;  ///< left, right, length
  double scale_bar_radius = 0.006;     ///< [m]
  std::optional<double> max_scale_error, max_heldout;
  bool skip_unreadable = false;
  CameraCalibrationOptions calibration;
};

/// The views and the size of the images.
struct Views {
  std::vector<BoardView> views;
  cv::Size size;
  std::size_t pairs = 0;
};

cv::Size parseSize(const std::string& text) {
  int width = 0, height = 0, read = 0;
  const bool good = std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &read) == 2 &&
                    read == static_cast<int>(text.size()) && width > 0 && height > 0;
  if (!good) throw ConfigError(fmt::format("--image-size: found '{}', expected WIDTHxHEIGHT as in 640x480", text));
  return {width, height};
}

Views viewsOfCorners(const Options& options, Session& session) {
  const Input& input = session.read("corners", options.corners);
  Views views;
  views.views = readCorners(CsvTable::parse(input.content, input.file.string(), options.table.csv()));
  views.size = parseSize(options.image_size);
  views.pairs = views.views.size();
  return views;
}

Views viewsOfImages(const Options& options) {
  const Board board = parseBoard(options.board);
  ImagePairs pairs(openImages(options.left), openImages(options.right), options.skip_unreadable);
  Progress progress("calibrate-cameras: pair", pairs.size().value_or(0), options.common.quiet);
  Views views;
  while (pairs.next()) {
    if (views.size.empty()) views.size = pairs.left().size();
    if (pairs.left().size() != views.size) {
      throw DataError(fmt::format("{}: found {}x{} px, the images before have {}x{}", pairs.leftName(),
                                  pairs.left().cols, pairs.left().rows, views.size.width, views.size.height));
    }
    BoardPoints left, right;
    tbb::parallel_invoke([&] { left = findBoard(pairs.left(), board); },
                         [&] { right = findBoard(pairs.right(), board); });
    const auto view = joinViews(board, std::filesystem::path(pairs.leftName()).filename().string(), left, right);
    if (view) views.views.push_back(*view);
    views.pairs = pairs.frame() + 1;
    progress.update(views.pairs);
    stopIfInterrupted();
  }
  return views;
}

std::optional<ScaleBarCheck> checkScaleBar(const Options& options, const StereoCameras& cameras) {
  if (options.scale_bar.empty()) return std::nullopt;
  const auto length = parseNumber(options.scale_bar[2]);
  if (!length || !(*length > 0.0)) {
    throw ConfigError(fmt::format("--scale-bar: found the length '{}', expected metres > 0", options.scale_bar[2]));
  }
  ScaleBarCheck check;
  check.nominal = *length;
  ImagePairs pairs(openImages(options.scale_bar[0]), openImages(options.scale_bar[1]), options.skip_unreadable);
  while (pairs.next()) {
    stopIfInterrupted();
    ++check.pairs;
    if (const auto d = measureScaleBar(cameras, pairs.left(), pairs.right(), options.scale_bar_radius)) {
      check.measured.add(*d);
    }
  }
  if (check.measured.count() == 0) {
    throw DataError(
        fmt::format("--scale-bar: none of {} pairs shows exactly two bright spheres in both images", check.pairs));
  }
  return check;
}

/// The cameras for other programs; those that do not have this lens model are left out and named.
void writeForOthers(const StereoCameras& cameras, const RunDirectory& directory) {
  directory.write("stereo.xml", writeStereoXml(cameras));
  if (const auto camchain = writeCamchain(cameras)) {
    directory.write("camchain.yaml", *camchain);
  } else {
    spdlog::info("camchain.yaml is left out: Kalibr's lens has k1 k2 p1 p2 alone (--distortion 4)");
  }
  if (const auto info = writeCameraInfo(cameras)) {
    directory.write("left_camera_info.yaml", (*info)[0]);
    directory.write("right_camera_info.yaml", (*info)[1]);
  }
}

void expectUsage(const Options& options) {
  const bool images = !options.left.empty() && !options.right.empty() && !options.board.empty();
  const bool corners = !options.corners.empty() && !options.image_size.empty();
  if (images == corners) {
    throw ConfigError("calibrate-cameras needs either LEFT RIGHT --board BOARD, or --corners CSV --image-size WxH");
  }
}

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  expectUsage(options);
  Session session("calibrate-cameras", options.common, argv);
  CameraCalibrationResult result;
  Views views = options.corners.empty() ? viewsOfImages(options) : viewsOfCorners(options, session);
  if (options.common.dry_run) {
    session.print(
        fmt::format("would calibrate from {} of {} pairs; nothing was written\n", views.views.size(), views.pairs));
    return ExitCode::kDone;
  }
  result.calibration = calibrateCameras(views.views, views.size, options.calibration);
  result.views = std::move(views.views);
  result.pairs = views.pairs;
  result.scale_bar = checkScaleBar(options, result.calibration.cameras);

  session.begin(options.common.seed.value_or(0));
  for (const std::size_t v : result.calibration.outliers) {
    spdlog::warn("view {} was left out: its error is over {:g} times the median", result.views[v].name,
                 options.calibration.outlier_ratio);
  }
  if (!result.scale_bar) spdlog::warn("without --scale-bar nothing but the board's own size says how long a metre is");
  const RunDirectory& directory = session.directory();
  directory.write("stereo.yaml",
                  writeStereo(result.calibration.cameras,
                              {fmt::format("simgap calibrate-cameras: {:.4f} px on held-out views, {} views",
                                           result.calibration.heldout_rms, result.views.size())}));
  writeForOthers(result.calibration.cameras, directory);
  directory.write("coverage.png", encodePng(drawCoverage(result.views, result.calibration.cameras.size)));
  session.finish(toJson(result), terminalTable(result));
  const bool scale_failed = options.max_scale_error && result.scale_bar &&
                            std::abs(result.scale_bar->errorPercent()) > *options.max_scale_error;
  const bool error_failed = options.max_heldout && result.calibration.heldout_rms > *options.max_heldout;
  return scale_failed || error_failed ? ExitCode::kCriterionFailed : ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  const auto positive = positiveNumber();
  app.add_option("LEFT", options->left, "images of the board by the left camera: a folder or a video");
  app.add_option("RIGHT", options->right, "by the right camera");
  app.add_option("--board", options->board, "KIND:COLSxROWS:SPACING_M, e.g. chessboard:9x6:0.025 (inner corners)");
  app.add_option("--corners", options->corners, "instead of images: corners another program has found (CSV)");
  app.add_option("--image-size", options->image_size, "WIDTHxHEIGHT of the images behind --corners");
  app.add_option("--distortion", options->calibration.distortion, "coefficients: 4, 5 or 8")
      ->check(CLI::IsMember({4, 5, 8}));
  app.add_option("--scale-bar", options->scale_bar,
                 "LEFT RIGHT LENGTH_M: images of two bright spheres at a known distance, to check the scale")
      ->expected(3);
  app.add_option("--scale-bar-radius", options->scale_bar_radius, "of its spheres [m]")->check(positive);
  app.add_option("--max-scale-error", options->max_scale_error, "exit 1 when the scale bar is off by more [%]")
      ->check(positive);
  app.add_option("--max-error", options->max_heldout, "exit 1 when the held-out reprojection error is larger [px]")
      ->check(positive);
  app.add_flag("--skip-unreadable", options->skip_unreadable, "go on behind images that cannot be read");
  options->table.add(app);
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"calibrate-cameras", "stereo cameras from views of a board, judged on views held out",
                    "  simgap calibrate-cameras data/boards/left data/boards/right \\\n"
                    "    --board chessboard:9x6:0.025 \\\n"
                    "    --scale-bar data/boards/bar-left data/boards/bar-right 0.300 \\\n"
                    "    -o runs/cameras",
                    define};

}  // namespace simgap::commands::calibrate_cameras
