// Calibrations of other programs: hand-written files of their documented formats, round trips, and hostile ones.
#include "simgap/capture/camera_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "support/arms.h"
#include "support/capture_study.h"
#include "support/files.h"

namespace simgap::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const reality::StereoLenses kPair = reality::standardLenses();

StereoCameras readText(const std::string& text) { return readCameras(std::vector<CameraFile>{{"c.yaml", text}}); }
StereoCameras readPair(const std::string& left, const std::string& right) {
  return readCameras(std::vector<CameraFile>{{"l.yaml", left}, {"r.yaml", right}});
}
std::string refusalOf(const std::string& text) {
  return errorOf([&] { readText(text); });
}
std::string refusalOf(const std::string& left, const std::string& right) {
  return errorOf([&] { readPair(left, right); });
}

/// The same pixels for the same points: what a camera is for.
void expectSame(const StereoCameras& found, const StereoCameras& truth, double pixels) {
  EXPECT_EQ(found.size, truth.size);
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.1, 0.2, 1.4), Eigen::Vector3d(-0.3, 0.1, 1.8), Eigen::Vector3d(0.05, -0.4, 2.2)}) {
    EXPECT_LT((projectPixel(found.left, point) - projectPixel(truth.left, point)).norm(), pixels);
    const auto right = [&](const StereoCameras& cameras) {
      return projectPixel(cameras.right, cameras.rotation * point + cameras.translation);
    };
    EXPECT_LT((right(found) - right(truth)).norm(), pixels);
  }
}

// ------------------------------------------------------------------------------------------------------------ Kalibr

/// As Kalibr writes it (its wiki, "Yaml formats"), with what only its other tools need.
const char* const kCamchain = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.27695497, 0.06712482, 0.00087538, 0.00011556]
  distortion_model: radtan
  intrinsics: [461.629, 460.152, 362.680, 246.049]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, -0.11003785]
  - [1.0, 0.0, 0.0, 0.00039]
  - [0.0, 0.0, 1.0, -0.0009]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.33518750, 0.13211436, 0.00055967, 0.00057686]
  distortion_model: radtan
  intrinsics: [460.2, 459.9, 373.850, 253.749]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
)";

TEST(CameraFiles, ReadsACamchain) {
  const StereoCameras cameras = readText(kCamchain);
  EXPECT_EQ(cameras.size, cv::Size(752, 480));
  EXPECT_EQ(cameras.left.K, cv::Matx33d(461.629, 0, 362.680, 0, 460.152, 246.049, 0, 0, 1));
  EXPECT_THAT(cameras.left.distortion, ElementsAre(-0.27695497, 0.06712482, 0.00087538, 0.00011556));
  EXPECT_THAT(cameras.right.distortion, ElementsAre(-0.33518750, 0.13211436, 0.00055967, 0.00057686));
  // A point of cam0 in cam1: x' = -y - 0.11, y' = x + 0.00039.
  const Eigen::Vector3d seen = cameras.rotation * Eigen::Vector3d(0.1, 0.2, 1.0) + cameras.translation;
  EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(-0.31003785, 0.10039, 0.9991), 1e-12)) << seen.transpose();
}

TEST(CameraFiles, RefusesACamchainOfAnotherKind) {
  const std::string good = kCamchain;
  EXPECT_THAT(refusalOf(replaced(good, "distortion_model: radtan", "distortion_model: equidistant")),
              AllOf(StartsWith("2: c.yaml:5: cam0.distortion_model: found 'equidistant'"), HasSubstr("radtan")));
  EXPECT_THAT(refusalOf(replaced(good, "camera_model: pinhole", "camera_model: omni")), HasSubstr("found 'omni'"));
  EXPECT_THAT(refusalOf(good + "cam2:\n  camera_model: pinhole\n"), HasSubstr("found a third camera"));
  EXPECT_THAT(refusalOf(replaced(good, "  T_cn_cnm1:", "  T_other:")), HasSubstr("T_cn_cnm1"));
  EXPECT_THAT(refusalOf(replaced(good, "[0.0, -1.0, 0.0, -0.11003785]", "[0.0, -1.1, 0.0, -0.11003785]")),
              HasSubstr("cam1.T_cn_cnm1: found no rotation"));
  EXPECT_THAT(refusalOf(replaced(good, "  - [0.0, 0.0, 0.0, 1.0]\n", "")), HasSubstr("found 3 rows, expected 4"));
  EXPECT_THAT(refusalOf(replaced(good, "[461.629,", "[1e300,")), HasSubstr("cam0.intrinsics[0]: found 1e300"));
  EXPECT_THAT(refusalOf(replaced(good, "[752, 480]", "[752000000, 480]")), HasSubstr("cam0.resolution[0]"));
}

TEST(CameraFiles, ACamchainComesBack) {
  const StereoCameras truth = camerasOf(kPair);
  const StereoCameras again = readText(writeCamchain(truth).value());
  EXPECT_EQ(again.left.K, truth.left.K);
  EXPECT_EQ(again.right.distortion, truth.right.distortion);
  EXPECT_EQ(again.translation, truth.translation);
  expectSame(again, truth, 1e-9);
}

TEST(CameraFiles, ALensThatKalibrDoesNotHaveIsNotWritten) {
  StereoCameras cameras = camerasOf(kPair);
  cameras.right.distortion = {-0.1, 0.04, 0.0, 0.0, 0.0};
  EXPECT_TRUE(writeCamchain(cameras).has_value());
  cameras.right.distortion[4] = 1e-3;
  EXPECT_FALSE(writeCamchain(cameras).has_value());
}

// --------------------------------------------------------------------------------------------------------------- ROS

/// As camera_calibration_parsers writes it. Rectified by turns of a quarter about x; 0.5 m apart along x.
std::string cameraInfo(const std::string& rectification, double offset) {
  return "image_width: 640\nimage_height: 480\ncamera_name: narrow_stereo\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [500., 0., 310.5, 0., 501., 240.25, 0., 0., 1.]\ndistortion_model: plumb_bob\n"
         "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.017697, -0.00727, 0.005751, -0.000139, 0.25]\n"
         "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [" +
         rectification + "]\nprojection_matrix:\n  rows: 3\n  cols: 4\n  data: [400., 0., 320., " +
         std::to_string(offset) + ", 0., 400., 240., 0., 0., 0., 1., 0.]\n";
}
const std::string kPlain = "1., 0., 0., 0., 1., 0., 0., 0., 1.", kQuarter = "1., 0., 0., 0., 0., -1., 0., 1., 0.";

TEST(CameraFiles, ReadsCameraInfo) {
  const StereoCameras cameras = readPair(cameraInfo(kPlain, 0.0), cameraInfo(kQuarter, -200.0));
  EXPECT_EQ(cameras.size, cv::Size(640, 480));
  EXPECT_EQ(cameras.left.K, cv::Matx33d(500, 0, 310.5, 0, 501, 240.25, 0, 0, 1));
  EXPECT_THAT(cameras.left.distortion, ElementsAre(-0.017697, -0.00727, 0.005751, -0.000139, 0.25));
  // Tx = -f B: 200 / 400 = 0.5 m. The right camera's frame has its y along the rectified z.
  const Eigen::Vector3d seen = cameras.rotation * Eigen::Vector3d(0.1, 0.2, 3.0) + cameras.translation;
  EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(-0.4, 3.0, -0.2), 1e-12)) << seen.transpose();
}

TEST(CameraFiles, RefusesCameraInfoOfAnotherKind) {
  const std::string left = cameraInfo(kPlain, 0.0), right = cameraInfo(kPlain, -200.0);
  EXPECT_THAT(refusalOf(left), HasSubstr("found the camera_info of one camera, expected that of the other one, too"));
  EXPECT_THAT(refusalOf(right, left), AllOf(StartsWith("2: l.yaml:18: projection_matrix"), HasSubstr("other order")));
  EXPECT_THAT(refusalOf(left, left), HasSubstr("these were calibrated each on its own"));
  EXPECT_THAT(refusalOf(left, replaced(right, "plumb_bob", "equidistant")), HasSubstr("found 'equidistant'"));
  EXPECT_THAT(refusalOf(left, replaced(right, "plumb_bob", "rational_polynomial")),
              HasSubstr("found 5 coefficients, expected those of rational_polynomial"));
  EXPECT_THAT(refusalOf(left, replaced(right, "image_width: 640", "image_width: 320")), HasSubstr("another size"));
  EXPECT_THAT(refusalOf(left, replaced(right, "rows: 3", "rows: 2000000000")), HasSubstr("found 2000000000"));
}

TEST(CameraFiles, CameraInfoComesBack) {
  for (const std::vector<double>& lens : {std::vector<double>{-0.1, 0.05, 1e-4, -3e-4},
                                          {-0.1, 0.05, 1e-4, -3e-4, 0.02},
                                          {-0.1, 0.05, 1e-4, -3e-4, 0.02, 0.01, -0.02, 0.003}}) {
    StereoCameras truth = camerasOf(kPair);
    truth.left.distortion = lens;
    const auto files = writeCameraInfo(truth).value();
    expectSame(readPair(files[0], files[1]), truth, 1e-9);
  }
  StereoCameras thin_prism = camerasOf(kPair);
  thin_prism.left.distortion.resize(12, 0.001);
  EXPECT_FALSE(writeCameraInfo(thin_prism).has_value());
}

TEST(CameraFiles, WrittenCameraInfoRectifiesARow) {
  // What P and R are for: a point is on one row of both rectified images, its columns differ by f B / z.
  const StereoCameras cameras = camerasOf(kPair);
  const auto files = writeCameraInfo(cameras).value();
  const auto matrixIn = [](const std::string& text, const std::string& key) {
    std::vector<double> numbers;
    const std::size_t begin = text.find('[', text.find(key)) + 1;
    std::istringstream words(text.substr(begin, text.find(']', begin) - begin));
    for (std::string word; std::getline(words, word, ',');) numbers.push_back(std::stod(word));
    return numbers;
  };
  // What R and P do to a point of a camera; its offset is for points of the left rectified frame.
  const auto rectified = [&](const std::string& text, const Eigen::Vector3d& point, double offset) {
    const auto r = matrixIn(text, "rectification_matrix"), p = matrixIn(text, "projection_matrix");
    const Eigen::Vector3d turned = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data()) * point;
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> projection(p.data());
    const Eigen::Vector3d pixel = projection.leftCols<3>() * turned + offset * projection.col(3);
    return Eigen::Vector3d(pixel.x() / pixel.z(), pixel.y() / pixel.z(), turned.z());
  };
  const Eigen::Vector3d point(0.1, -0.2, 1.5), in_right = cameras.rotation * point + cameras.translation;
  const Eigen::Vector3d left = rectified(files[0], point, 0.0), right = rectified(files[1], in_right, 0.0);
  const double focal = matrixIn(files[0], "projection_matrix")[0];
  EXPECT_NEAR(left.y(), right.y(), 1e-9);
  EXPECT_NEAR(left.x() - right.x(), focal * kPair.translation.norm() / left.z(), 1e-9);
  // P of the right camera takes points of the left one's rectified frame, too.
  const std::string mixed = replaced(files[0], files[0].substr(files[0].find("projection_matrix")),
                                     files[1].substr(files[1].find("projection_matrix")));
  EXPECT_NEAR(rectified(mixed, point, 1.0).x(), right.x(), 1e-9);
}

// ------------------------------------------------------------------------------------------------------------ OpenCV

/// As OpenCV's stereo sample writes it (intrinsics and extrinsics in one file).
std::string openCvXml(const std::string& first = "\n    500. 0. 3.105e+02 0. 501. 240.25 0. 0. 1.") {
  const auto matrix = [](const std::string& name, int rows, int cols, const std::string& data) {
    return "<" + name + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(rows) + "</rows>\n  <cols>" +
           std::to_string(cols) + "</cols>\n  <dt>d</dt>\n  <data>" + data + "</data></" + name + ">\n";
  };
  return "<?xml "
         "version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n<image_height>480</image_height>\n" +
         matrix("M1", 3, 3, first) + matrix("D1", 1, 4, "-0.1 0.05 1e-4\n -3e-4") +
         matrix("M2", 3, 3, "502 0 320 0 503 240 0 0 1") + matrix("D2", 1, 4, "0 0 0 0") +
         matrix("R", 3, 3, "1 0 0 0 0 -1 0 1 0") + matrix("T", 3, 1, "-0.35 0.01 0.02") + "</opencv_storage>\n";
}

TEST(CameraFiles, ReadsOpenCvXml) {
  const StereoCameras cameras = readText(openCvXml());
  EXPECT_EQ(cameras.size, cv::Size(640, 480));
  EXPECT_EQ(cameras.left.K, cv::Matx33d(500, 0, 310.5, 0, 501, 240.25, 0, 0, 1));
  EXPECT_THAT(cameras.left.distortion, ElementsAre(-0.1, 0.05, 1e-4, -3e-4));
  const Eigen::Vector3d seen = cameras.rotation * Eigen::Vector3d(0.1, 0.2, 1.0) + cameras.translation;
  EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(-0.25, -0.99, 0.22), 1e-12)) << seen.transpose();
}

TEST(CameraFiles, OpenCvXmlAndYamlComeBack) {
  const StereoCameras truth = camerasOf(kPair);
  for (const std::string& text :
       {writeStereoXml(truth), writeStereo(truth, {"a comment"}), reality::stereoYaml(kPair)}) {
    const StereoCameras again = readText(text);
    EXPECT_EQ(again.right.K, truth.right.K);
    EXPECT_EQ(again.left.distortion, truth.left.distortion);
    expectSame(again, truth, 1e-9);
  }
}

TEST(CameraFiles, RefusesHostileXml) {
  const std::string good = openCvXml();
  std::string deep = "<opencv_storage>";
  for (int i = 0; i < 20000; ++i) deep += "<a>";
  EXPECT_THAT(refusalOf(deep), StartsWith("2: c.yaml:1: found no XML"));
  EXPECT_THAT(refusalOf(good.substr(0, good.size() / 2)), StartsWith("2: c.yaml:"));
  EXPECT_THAT(refusalOf(replaced(good, "<rows>3</rows>", "<rows>2000000</rows>")),
              HasSubstr("c.yaml:6: rows: found no integer from 1 to 100"));
  EXPECT_THAT(refusalOf(replaced(good, "<rows>3</rows>", "<rows>4</rows>")),
              HasSubstr("data: found 9 numbers, expected 4 x 3"));
  EXPECT_THAT(refusalOf(replaced(good, "500. 0.", "nan 0.")), HasSubstr("data: found 'nan', expected a number"));
  EXPECT_THAT(refusalOf(replaced(good, "500. 0.", "1e300 0.")), HasSubstr("data: found '1e300'"));
  EXPECT_THAT(refusalOf(replaced(good, "<D2 ", "<M1 ")), StartsWith("2: c.yaml:"));
  EXPECT_THAT(refusalOf("<html></html>"), HasSubstr("found no element opencv_storage"));
  EXPECT_THAT(refusalOf(std::string(2 << 20, ' ')), HasSubstr("expected a calibration of at most 1048576"));
}

TEST(CameraFiles, SaysWhatItWouldTake) {
  EXPECT_THAT(refusalOf("a: 1\n"), HasSubstr("found no calibration of two cameras, expected OpenCV's file storage"));
  EXPECT_THAT(refusalOf(""), StartsWith("2: c.yaml"));
}

}  // namespace
}  // namespace simgap::test
