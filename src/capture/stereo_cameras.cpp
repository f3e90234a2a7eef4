#include "simgap/capture/stereo_cameras.h"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>
#include <string_view>

#include "simgap/core/error.h"
#include "simgap/core/yaml.h"

namespace simgap {
namespace {

constexpr Range kLensNumber{-1e9, 1e9, false, "a number of a size of at most 1e9"};

/// OpenCV's own reader trusts what it reads: it allocates what `rows` and `cols` say and calls itself for every
/// bracket. What it writes is YAML but for the first line.
YamlNode parseStorage(const std::string& text, const std::string& file) {
  constexpr std::string_view kDirective = "%YAML:1.0";
  if (!text.starts_with(kDirective)) {
    throw ConfigError(
        fmt::format("{}: found no OpenCV file storage, expected YAML that begins with {}", file, kDirective));
  }
  return YamlNode::parse("#" + text, file);  // a comment, so that lines keep their numbers
}

cv::Mat readMatrix(const YamlNode& storage, const std::vector<std::string>& names, const std::string& file) {
  constexpr long kMostRows = 100;
  for (const std::string& name : names) {
    const auto node = storage.find(name);
    if (!node) continue;
    const int rows = static_cast<int>(node->at("rows").integer(1, kMostRows));
    const int cols = static_cast<int>(node->at("cols").integer(1, kMostRows));
    const YamlNode data = node->at("data");
    const std::vector<YamlNode> items = data.items();
    if (std::ssize(items) != rows * cols) {
      data.fail(fmt::format("found {} numbers, expected {} x {}", items.size(), rows, cols));
    }
    cv::Mat matrix(rows, cols, CV_64F);
    for (int i = 0; i < rows * cols; ++i) matrix.at<double>(i / cols, i % cols) = items[i].number(kLensNumber);
    return matrix;
  }
  throw ConfigError(fmt::format("{}: {} is missing (also looked for {})", file, names.front(),
                                fmt::join(names.begin() + 1, names.end(), ", ")));
}

void expectShape(const cv::Mat& matrix, int rows, int cols, const std::string& name, const std::string& file) {
  if (matrix.rows == rows && matrix.cols == cols) return;
  throw ConfigError(
      fmt::format("{}: {}: found {}x{}, expected {}x{}", file, name, matrix.rows, matrix.cols, rows, cols));
}

CameraIntrinsics readCamera(const YamlNode& storage, const std::string& side, const std::string& file) {
  const cv::Mat k = readMatrix(storage, {"K" + side, "M" + side, "cameraMatrix" + side, "camera_matrix" + side}, file);
  expectShape(k, 3, 3, "K" + side, file);
  const cv::Mat d = readMatrix(storage, {"D" + side, "distCoeffs" + side, "dist_coeffs" + side}, file);
  CameraIntrinsics camera;
  camera.K = k;
  camera.distortion.assign(d.begin<double>(), d.end<double>());
  const std::size_t n = camera.distortion.size();
  if (n != 4 && n != 5 && n != 8 && n != 12 && n != 14) {
    throw ConfigError(fmt::format("{}: D{}: found {} coefficients, expected 4, 5, 8, 12 or 14", file, side, n));
  }
  if (!(k.at<double>(0, 0) > 0.0 && k.at<double>(1, 1) > 0.0)) {
    throw ConfigError(fmt::format("{}: K{}: found focal lengths {:g} and {:g} px, expected numbers > 0", file, side,
                                  k.at<double>(0, 0), k.at<double>(1, 1)));
  }
  return camera;
}

/// A side of the images in pixels; 0 when the file does not say.
int readSide(const YamlNode& storage, const char* name) {
  constexpr long kMostPixels = 1 << 16;
  const auto node = storage.find(name);
  return node ? static_cast<int>(node->integer(0, kMostPixels)) : 0;
}

void writeCamera(cv::FileStorage& storage, const CameraIntrinsics& camera, const std::string& side) {
  storage << "K" + side << cv::Mat(camera.K);
  storage << "D" + side << cv::Mat(camera.distortion).reshape(1, 1);
}

}  // namespace

Eigen::Matrix3d StereoCameras::essential() const {
  Eigen::Matrix3d cross;
  const Eigen::Vector3d& t = translation;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  return cross * rotation;
}

StereoCameras readStereo(const std::string& text, const std::string& file) {
  const YamlNode storage = parseStorage(text, file);
  StereoCameras cameras;
  cameras.size = {readSide(storage, "image_width"), readSide(storage, "image_height")};
  cameras.left = readCamera(storage, "1", file);
  cameras.right = readCamera(storage, "2", file);
  const cv::Mat r = readMatrix(storage, {"R"}, file);
  expectShape(r, 3, 3, "R", file);
  cv::Mat t = readMatrix(storage, {"T"}, file);
  if (t.rows == 1) t = t.t();
  expectShape(t, 3, 1, "T", file);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) cameras.rotation(i, j) = r.at<double>(i, j);
    cameras.translation[i] = t.at<double>(i);
  }
  const double skew = (cameras.rotation * cameras.rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (skew > 1e-4 || cameras.rotation.determinant() < 0.0) {
    throw ConfigError(fmt::format("{}: R: found no rotation (R R' misses the identity by {:.2g})", file, skew));
  }
  cameras.rotation = Eigen::Quaterniond(cameras.rotation).normalized().toRotationMatrix();
  if (!(cameras.baseline() > 0.0)) throw ConfigError(fmt::format("{}: T: found no distance between the cameras", file));
  return cameras;
}

std::string writeStereo(const StereoCameras& cameras, const std::vector<std::string>& comments) {
  cv::FileStorage storage("stereo.yaml",
                          cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  for (const std::string& comment : comments) storage.writeComment(comment);
  storage << "image_width" << cameras.size.width << "image_height" << cameras.size.height;
  writeCamera(storage, cameras.left, "1");
  writeCamera(storage, cameras.right, "2");
  cv::Mat r(3, 3, CV_64F), t(3, 1, CV_64F);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r.at<double>(i, j) = cameras.rotation(i, j);
    t.at<double>(i) = cameras.translation[i];
  }
  storage << "R" << r << "T" << t;
  return storage.releaseAndGetString();
}

void undistort(const CameraIntrinsics& camera, const std::vector<cv::Point2d>& pixels,
               std::vector<cv::Point2d>& normalized) {
  normalized.resize(pixels.size());
  if (pixels.empty()) return;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12);
  cv::undistortPoints(pixels, normalized, camera.K, camera.distortion, cv::noArray(), cv::noArray(), until);
}

Eigen::Vector2d projectPixel(const CameraIntrinsics& camera, const Eigen::Vector3d& point) {
  const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera.K, camera.distortion, pixels);
  return {pixels[0].x, pixels[0].y};
}

}  // namespace simgap
