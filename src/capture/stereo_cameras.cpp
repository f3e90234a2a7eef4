#include "simgap/capture/stereo_cameras.h"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// OpenCV prints its errors before it throws them.
class QuietErrors {
 public:
  QuietErrors() {
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
  }
  ~QuietErrors() { cv::redirectError(nullptr); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
};

cv::FileStorage openStorage(const std::string& text, const std::string& file) {
  const QuietErrors quiet;
  try {
    cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (storage.isOpened()) return storage;
  } catch (const cv::Exception&) {
  }
  throw ConfigError(fmt::format("{}: found no OpenCV file storage, expected YAML that begins with %YAML:1.0", file));
}

cv::Mat readMatrix(const cv::FileStorage& storage, const std::vector<std::string>& names, const std::string& file) {
  for (const std::string& name : names) {
    const cv::FileNode node = storage[name];
    if (node.empty()) continue;
    cv::Mat matrix;
    const QuietErrors quiet;
    try {
      node >> matrix;
      matrix.convertTo(matrix, CV_64F);
    } catch (const cv::Exception&) {
      matrix.release();
    }
    if (matrix.empty() || !cv::checkRange(matrix)) {
      throw ConfigError(fmt::format("{}: {}: expected a matrix of finite numbers", file, name));
    }
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

CameraIntrinsics readCamera(const cv::FileStorage& storage, const std::string& side, const std::string& file) {
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
  const cv::FileStorage storage = openStorage(text, file);
  StereoCameras cameras;
  if (!storage["image_width"].empty()) cameras.size.width = static_cast<int>(storage["image_width"]);
  if (!storage["image_height"].empty()) cameras.size.height = static_cast<int>(storage["image_height"]);
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
