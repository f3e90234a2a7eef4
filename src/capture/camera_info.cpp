// ROS's camera_info files: sensor_msgs/CameraInfo as camera_calibration_parsers writes it, and REP 104.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <opencv2/calib3d.hpp>

#include "camera_formats.h"
#include "camera_storage.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

/// One camera: what it sees, R into the rectified frame of both, P from there to pixels.
struct CameraInfo {
  CameraIntrinsics camera;
  cv::Size size;
  Eigen::Matrix3d r;
  Eigen::Matrix<double, 3, 4> p;
};

cv::Mat matrixNamed(const YamlNode& root, const std::string& key, int rows, int cols) {
  const YamlNode node = root.at(key);
  cv::Mat matrix = matrixOf(node);
  if (matrix.rows != rows || matrix.cols != cols) {
    node.fail(fmt::format("found {}x{} numbers, expected {}x{}", matrix.rows, matrix.cols, rows, cols));
  }
  return matrix;
}

CameraInfo readInfo(const YamlNode& root, const std::string& file) {
  CameraInfo info;
  info.size = {sideOf(root.at("image_width")), sideOf(root.at("image_height"))};
  const auto model = root.find("distortion_model");  // files that are older than it have a plumb bob
  const std::string lens = model ? model->oneOf({"plumb_bob", "rational_polynomial"}) : "plumb_bob";
  const YamlNode node = root.at("distortion_coefficients");
  const cv::Mat d = matrixOf(node);
  const bool fits = lens == "plumb_bob" ? d.total() == 4 || d.total() == 5 : d.total() == 8;
  if (!fits) node.fail(fmt::format("found {} coefficients, expected those of {}", d.total(), lens));
  info.camera = checkedCamera(matrixNamed(root, "camera_matrix", 3, 3), {d.begin<double>(), d.end<double>()},
                              file + ": camera_matrix", file + ": distortion_coefficients");
  info.r = eigenOf(matrixNamed(root, "rectification_matrix", 3, 3));
  info.p = eigenOf(matrixNamed(root, "projection_matrix", 3, 4));
  if (!(info.p(0, 0) > 0.0 && info.p(1, 1) > 0.0)) {
    root.at("projection_matrix").fail("found a focal length that is not above 0, expected one that is");
  }
  return info;
}

/// Where the left camera's centre stands in the right camera's rectified frame: [m].
Eigen::Vector3d rectifiedOffset(const CameraInfo& info) {
  return {info.p(0, 3) / info.p(0, 0), info.p(1, 3) / info.p(1, 1), 0.0};
}

std::string matrixText(const std::string& key, const cv::Mat& matrix) {
  const std::vector<double> numbers(matrix.begin<double>(), matrix.end<double>());
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", key, matrix.rows, matrix.cols,
                     fmt::join(numbers, ", "));
}

std::string infoText(const std::string& name, const CameraIntrinsics& camera, cv::Size size, const cv::Mat& r,
                     const cv::Mat& p) {
  std::vector<double> d = camera.distortion;
  if (d.size() < 5) d.resize(5, 0.0);
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", size.width, size.height, name) +
         matrixText("camera_matrix", cv::Mat(camera.K)) +
         fmt::format("distortion_model: {}\n", d.size() == 5 ? "plumb_bob" : "rational_polynomial") +
         matrixText("distortion_coefficients", cv::Mat(d).t()) + matrixText("rectification_matrix", r) +
         matrixText("projection_matrix", p);
}

}  // namespace

StereoCameras readCameraInfo(const std::array<YamlNode, 2>& roots, const std::array<std::string, 2>& files) {
  const CameraInfo left = readInfo(roots[0], files[0]), right = readInfo(roots[1], files[1]);
  if (left.size != right.size) roots[1].at("image_width").fail("found another size than that of the left camera");
  const YamlNode left_projection = roots[0].at("projection_matrix"), projection = roots[1].at("projection_matrix");
  if (!rectifiedOffset(left).isZero(0.0)) {
    left_projection.fail(
        "found an offset (numbers 4 and 8), expected none for the left camera: are the files in the "
        "other order?");
  }
  if (rectifiedOffset(right).isZero(0.0)) {
    projection.fail(
        "found no offset (numbers 4 and 8), expected the distance of the cameras: these were calibrated each "
        "on its own");
  }
  StereoCameras cameras;
  cameras.size = left.size;
  cameras.left = left.camera;
  cameras.right = right.camera;
  setPose(cameras, right.r.transpose() * left.r, right.r.transpose() * rectifiedOffset(right),
          files[1] + ": rectification_matrix", files[1] + ": projection_matrix");
  return cameras;
}

std::optional<std::array<std::string, 2>> writeCameraInfo(const StereoCameras& cameras) {
  if (std::max(cameras.left.distortion.size(), cameras.right.distortion.size()) > 8) return std::nullopt;
  cv::Mat r1, r2, p1, p2, q;
  constexpr double kAllValid = 0.0;
  cv::stereoRectify(cameras.left.K, cameras.left.distortion, cameras.right.K, cameras.right.distortion, cameras.size,
                    matOf(cameras.rotation), matOf(cameras.translation), r1, r2, p1, p2, q, cv::CALIB_ZERO_DISPARITY,
                    kAllValid);
  return std::array{infoText("left", cameras.left, cameras.size, r1, p1),
                    infoText("right", cameras.right, cameras.size, r2, p2)};
}

}  // namespace simgap
