// Cameras from boards: known lenses, and public recordings when they are beside the repository.
#include "simgap/capture/camera_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "support/arms.h"
#include "support/capture_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::HasSubstr;

/// A 9x6 board of 25 mm in random positions, corners with noise [px].
std::vector<BoardView> boardViews(const reality::StereoLenses& lenses, int count, double noise) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  std::vector<BoardView> views;
  while (int(views.size()) < count) {
    const Eigen::Vector3d axis = randomDirection(random);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(uniform(random, -0.6, 0.6), axis));
    const double z = uniform(random, 0.6, 1.2), y = uniform(random, -0.2, 0.2), x = uniform(random, -0.15, 0.35);
    const Eigen::Vector3d place(x, y, z);
    BoardView view{std::to_string(views.size()), {}, {}, {}};
    bool inside = true;
    for (int k = 0; k < 54; ++k) {
      const Eigen::Vector3d corner(0.025 * (k % 9), 0.025 * (k / 9), 0.0);
      const Eigen::Vector3d p = turn * (corner - Eigen::Vector3d(0.1, 0.06, 0)) + place;
      const auto image = [&](const reality::Lens& lens, const Eigen::Vector3d& q) {
        Eigen::Vector2d pixel = lens.project(q);
        inside = inside && pixel.x() > 0 && pixel.y() > 0 && pixel.x() < lens.width && pixel.y() < lens.height;
        const double v = normal(random), u = normal(random);
        pixel += noise * Eigen::Vector2d(u, v);
        return cv::Point2f(float(pixel.x()), float(pixel.y()));
      };
      view.board.emplace_back(float(corner.x()), float(corner.y()), 0.0F);
      view.left.push_back(image(lenses.left, p));
      view.right.push_back(image(lenses.right, lenses.rotation * p + lenses.translation));
    }
    if (inside) views.push_back(view);
  }
  return views;
}

double numberOf(const CameraCalibration& c, const std::string& name, bool sd = false) {
  for (const CalibratedNumber& n : c.numbers) {
    if (n.name == name) return sd ? n.sd : n.value;
  }
  ADD_FAILURE() << name;
  return 0.0;
}

TEST(CameraCalibration, FindsKnownLensesWithinItsDeviations) {
  const reality::StereoLenses lenses = reality::standardLenses();
  std::vector<BoardView> views = boardViews(lenses, 24, 0.1);
  CameraCalibrationOptions options;
  options.distortion = 4;
  const CameraCalibration found = calibrateCameras(views, {640, 480}, options);
  EXPECT_TRUE(found.outliers.empty());
  // 0.1 px per axis: 0.14 px per point; views that were held out are met a little worse.
  EXPECT_NEAR(found.rms, 0.1 * std::sqrt(2.0), 0.02);
  EXPECT_GT(found.heldout_rms, found.rms);
  EXPECT_LT(found.heldout_rms, 1.2 * found.rms);
  const auto expectNear = [&](const std::string& name, double truth) {
    EXPECT_NEAR(numberOf(found, name), truth, 4.0 * numberOf(found, name, true)) << name;
    EXPECT_GT(numberOf(found, name, true), 0.0) << name;
  };
  expectNear("left fx", 800.0);
  expectNear("right fy", 801.6);
  expectNear("left cx", 323.1);
  expectNear("left k1", -0.11);
  expectNear("baseline", 1e3 * lenses.translation.norm());
  EXPECT_LT(numberOf(found, "baseline", true), 1.0);
  const Eigen::AngleAxisd off(Eigen::Matrix3d(found.cameras.rotation * lenses.rotation.transpose()));
  EXPECT_LT(off.angle(), 2e-3);
}

TEST(CameraCalibration, LeavesOutABadViewAndNamesIt) {
  std::vector<BoardView> views = boardViews(reality::standardLenses(), 16, 0.1);
  for (auto& p : views[5].right) p.y += 4.0F;  // the board moved between the two exposures
  const CameraCalibration found = calibrateCameras(views, {640, 480}, {});
  EXPECT_EQ(found.outliers, std::vector<std::size_t>{5});
  EXPECT_TRUE(std::isnan(found.view_rms[5]));
  EXPECT_LT(found.rms, 0.2);
}

TEST(CameraCalibration, RefusesTooFewViews) {
  const auto views = boardViews(reality::standardLenses(), 3, 0.1);
  EXPECT_THAT(errorOf([&] {
                calibrateCameras(views, {640, 480}, {});
              }),
              HasSubstr("3: the board was seen by both cameras in 3 views, expected at least 6"));
}

TEST(CameraCalibration, ThreadsDoNotChangeTheResult) {
  const auto views = boardViews(reality::standardLenses(), 8, 0.1);
  CameraCalibrationOptions one, two;
  one.threads = 1;
  two.threads = 2;
  const CameraCalibration a = calibrateCameras(views, {640, 480}, one);
  const CameraCalibration b = calibrateCameras(views, {640, 480}, two);
  for (std::size_t i = 0; i < a.numbers.size(); ++i) EXPECT_EQ(a.numbers[i].sd, b.numbers[i].sd);
}

TEST(CameraCalibration, MeasuresAScaleBar) {
  const reality::StereoLenses lenses = reality::standardLenses();
  const reality::Camera left(lenses.left, {}), right(lenses.right, {});
  std::vector<reality::Sphere> spheres = {{{-0.05, 0.02, 1.1}}, {{0.15, -0.03, 1.2}}};
  const double length = (spheres[0].centre - spheres[1].centre).norm();
  const reality::Image a = left.render({spheres}, {}, 1);
  for (auto& s : spheres) s.centre = lenses.rotation * s.centre + lenses.translation;
  const reality::Image b = right.render({spheres}, {}, 2);
  const auto measured = measureScaleBar(camerasOf(lenses), matOf(a), matOf(b), 0.006);
  ASSERT_TRUE(measured.has_value());
  EXPECT_NEAR(*measured, length, 0.15e-3);
}

TEST(Board, ReadsItsDescription) {
  const Board chess = parseBoard("chessboard:9x6:0.025");
  EXPECT_EQ(chess.size, cv::Size(9, 6));
  EXPECT_EQ(chess.spacing, 0.025);
  EXPECT_EQ(parseBoard("charuco:7x5:0.04:0.03:5X5_100").dictionary, "5X5_100");
  for (const char* bad :
       {"", "chessboard", "chessboard:9x6", "chessboard:9x6:0", "chessboard:9x6:0.02:0.01", "x:9x6:1",
        "chessboard:2x6:0.02", "charuco:7x5:0.04:0.05", "charuco:7x5:0.04:0.03:9X9", "chessboard:9:1"}) {
    EXPECT_THAT(errorOf([&] { parseBoard(bad); }), HasSubstr("2: --board: found '")) << bad;
  }
}

TEST(Board, TurnsARowOfCornersThatRunsBackwards) {
  const Board board = parseBoard("chessboard:9x6:0.025");
  BoardPoints left, right;
  for (int k = 0; k < 54; ++k) {
    left.ids.push_back(k);
    left.pixels.emplace_back(float(k % 9), float(k / 9));
  }
  right = left;
  std::reverse(right.pixels.begin(), right.pixels.end());
  const auto view = joinViews(board, "v", left, right);
  ASSERT_TRUE(view.has_value());
  EXPECT_EQ(view->left, view->right);
}

/// A chessboard as a plain picture: both of OpenCV's detectors see only pixels.
TEST(Board, IsFoundInAnImage) {
  cv::Mat image(400, 560, CV_8UC1, cv::Scalar(255));
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 10; ++x) {
      if ((x + y) % 2 == 0) image(cv::Rect(30 + 50 * x, 25 + 50 * y, 50, 50)).setTo(0);
    }
  }
  const BoardPoints points = findBoard(image, parseBoard("chessboard:9x6:0.025"));
  ASSERT_EQ(points.pixels.size(), 54u);
  EXPECT_TRUE(findBoard(image, parseBoard("chessboard:8x5:0.025")).pixels.size() != 54u);
  EXPECT_TRUE(findBoard(cv::Mat(400, 560, CV_8UC1, cv::Scalar(128)), parseBoard("circles:5x4:0.02")).ids.empty());
}

// ------------------------------------------------------------------------------------------- public recordings

class SlowRealChessboards : public testing::Test {
 protected:
  /// Skips when the recordings are not beside the repository.
  static std::filesystem::path recording(const std::string& name) {
    for (const char* up : {"../shared/data/real/", "../../shared/data/real/"}) {
      const auto file = sourceFile(std::string(up) + name);
      if (std::filesystem::exists(file)) return file;
    }
    return {};
  }
};

TEST_F(SlowRealChessboards, XimeaAgreesWithThePublishedCalibration) {
  const auto file = recording("stereo_chessboards/ximea_corners.csv.gz");
  if (file.empty()) GTEST_SKIP() << "the public recordings are not beside the repository";
  const CameraCalibration found = calibrateCameras(readCorners(CsvTable::load(file)), {640, 512}, {});
  std::printf("ximea: held out %.3f px, fx %.2f +- %.2f (published 518.05), baseline %.2f +- %.2f mm (92.05)\n",
              found.heldout_rms, numberOf(found, "left fx"), numberOf(found, "left fx", true),
              numberOf(found, "baseline"), numberOf(found, "baseline", true));
  EXPECT_NEAR(numberOf(found, "left fx"), 518.05, 3.0 * numberOf(found, "left fx", true));
  EXPECT_NEAR(numberOf(found, "baseline"), 92.05, 3.0 * numberOf(found, "baseline", true));
  EXPECT_LT(found.heldout_rms, 0.2);
}

TEST_F(SlowRealChessboards, MarkerRigLiesBetweenItsStatedBaselines) {
  const auto file = recording("tdcr_stereo_markers/chessboard_corners.csv.gz");
  if (file.empty()) GTEST_SKIP() << "the public recordings are not beside the repository";
  const CameraCalibration found = calibrateCameras(readCorners(CsvTable::load(file)), {840, 600}, {});
  std::printf("tdcr: held out %.3f px, baseline %.2f +- %.2f mm (stated 72.99, nominal 75)\n", found.heldout_rms,
              numberOf(found, "baseline"), numberOf(found, "baseline", true));
  EXPECT_GT(numberOf(found, "baseline"), 72.99);
  EXPECT_LT(numberOf(found, "baseline"), 75.0);
  EXPECT_LT(found.heldout_rms, 0.15);
}

}  // namespace
}  // namespace simgap::test
