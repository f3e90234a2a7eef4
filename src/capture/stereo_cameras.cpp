#include "simgap/capture/stereo_cameras.h"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>
#include <string_view>

#include "camera_storage.h"
#include "simgap/capture/camera_files.h"
#include "simgap/core/error.h"
#include "simgap/core/yaml.h"

namespace simgap {
namespace {

constexpr std::string_view kDirective = "%YAML:1.0";

class YamlStorage : public CameraStorage {
 public:
  explicit YamlStorage(YamlNode root) : root_(std::move(root)) {}
  std::optional<cv::Mat> matrix(const std::string& name) const override {
    const auto node = root_.find(name);
    return node ? std::optional(matrixOf(*node)) : std::nullopt;
  }
  int side(const std::string& name) const override {
    const auto node = root_.find(name);
    return node ? sideOf(*node) : 0;
  }

 private:
  YamlNode root_;
};

cv::Mat readMatrix(const CameraStorage& storage, const std::vector<std::string>& names, const std::string& file) {
  for (const std::string& name : names) {
    if (const auto matrix = storage.matrix(name)) return *matrix;
  }
  throw ConfigError(fmt::format("{}: {} is missing (also looked for {})", file, names.front(),
                                fmt::join(names.begin() + 1, names.end(), ", ")));
}

void expectShape(const cv::Mat& matrix, int rows, int cols, const std::string& name, const std::string& file) {
  if (matrix.rows == rows && matrix.cols == cols) return;
  throw ConfigError(
      fmt::format("{}: {}: found {}x{}, expected {}x{}", file, name, matrix.rows, matrix.cols, rows, cols));
}

CameraIntrinsics readCamera(const CameraStorage& storage, const std::string& side, const std::string& file) {
  const cv::Mat k = readMatrix(storage, {"K" + side, "M" + side, "cameraMatrix" + side, "camera_matrix" + side}, file);
  expectShape(k, 3, 3, "K" + side, file);
  const cv::Mat d = readMatrix(storage, {"D" + side, "distCoeffs" + side, "dist_coeffs" + side}, file);
  return checkedCamera(k, {d.begin<double>(), d.end<double>()}, fmt::format("{}: K{}", file, side),
                       fmt::format("{}: D{}", file, side));
}

void writeCamera(cv::FileStorage& storage, const CameraIntrinsics& camera, const std::string& side) {
  storage << "K" + side << cv::Mat(camera.K);
  storage << "D" + side << cv::Mat(camera.distortion).reshape(1, 1);
}

}  // namespace

Eigen::MatrixXd eigenOf(const cv::Mat& matrix) {
  Eigen::MatrixXd result(matrix.rows, matrix.cols);
  for (int i = 0; i < matrix.rows; ++i) {
    for (int j = 0; j < matrix.cols; ++j) result(i, j) = matrix.at<double>(i, j);
  }
  return result;
}

cv::Mat matOf(const Eigen::MatrixXd& matrix) {
  cv::Mat result(static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols()), CV_64F);
  for (int i = 0; i < result.rows; ++i) {
    for (int j = 0; j < result.cols; ++j) result.at<double>(i, j) = matrix(i, j);
  }
  return result;
}

cv::Mat matrixOf(const YamlNode& node) {
  const int rows = static_cast<int>(node.at("rows").integer(1, kMostStorageRows));
  const int cols = static_cast<int>(node.at("cols").integer(1, kMostStorageRows));
  const YamlNode data = node.at("data");
  const std::vector<YamlNode> items = data.items();
  if (std::ssize(items) != rows * cols) {
    data.fail(fmt::format("found {} numbers, expected {} x {}", items.size(), rows, cols));
  }
  cv::Mat matrix(rows, cols, CV_64F);
  for (int i = 0; i < rows * cols; ++i) matrix.at<double>(i / cols, i % cols) = items[i].number(kLensNumber);
  return matrix;
}

int sideOf(const YamlNode& node) { return static_cast<int>(node.integer(0, kMostPixels)); }

CameraIntrinsics checkedCamera(const cv::Matx33d& k, std::vector<double> distortion, const std::string& k_name,
                               const std::string& d_name) {
  const std::size_t n = distortion.size();
  if (n != 4 && n != 5 && n != 8 && n != 12 && n != 14) {
    throw ConfigError(fmt::format("{}: found {} coefficients, expected 4, 5, 8, 12 or 14", d_name, n));
  }
  if (!(k(0, 0) > 0.0 && k(1, 1) > 0.0)) {
    throw ConfigError(
        fmt::format("{}: found focal lengths {:g} and {:g} px, expected numbers > 0", k_name, k(0, 0), k(1, 1)));
  }
  CameraIntrinsics camera;
  camera.K = k;
  camera.distortion = std::move(distortion);
  return camera;
}

void setPose(StereoCameras& cameras, const Eigen::Matrix3d& r, const Eigen::Vector3d& t, const std::string& r_name,
             const std::string& t_name) {
  const double skew = (r * r.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (skew > 1e-4 || r.determinant() < 0.0) {
    throw ConfigError(fmt::format("{}: found no rotation (R R' misses the identity by {:.2g})", r_name, skew));
  }
  cameras.rotation = Eigen::Quaterniond(r).normalized().toRotationMatrix();
  cameras.translation = t;
  if (!(cameras.baseline() > 0.0)) throw ConfigError(fmt::format("{}: found no distance between the cameras", t_name));
}

Eigen::Matrix3d StereoCameras::essential() const {
  Eigen::Matrix3d cross;
  const Eigen::Vector3d& t = translation;
  cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  return cross * rotation;
}

StereoCameras readStereo(const std::string& text, const std::string& file) {
  if (!isStereoYaml(text)) {
    throw ConfigError(
        fmt::format("{}: found no OpenCV file storage, expected YAML that begins with {}", file, kDirective));
  }
  return stereoFromYaml(parseCameraYaml(text, file), file);
}

bool isStereoYaml(const std::string& text) { return text.starts_with(kDirective); }

// OpenCV's own reader trusts what it reads: it allocates what `rows` and `cols` say and calls itself for every bracket.
// What it writes is YAML but for the first line.
YamlNode parseCameraYaml(const std::string& text, const std::string& file) {
  return YamlNode::parse(text.starts_with("%YAML") ? "#" + text : text, file);  // a comment: lines keep their numbers
}

StereoCameras stereoFromYaml(const YamlNode& root, const std::string& file) {
  return stereoFrom(YamlStorage(root), file);
}

StereoCameras stereoFrom(const CameraStorage& storage, const std::string& file) {
  StereoCameras cameras;
  cameras.size = {storage.side("image_width"), storage.side("image_height")};
  cameras.left = readCamera(storage, "1", file);
  cameras.right = readCamera(storage, "2", file);
  const cv::Mat r = readMatrix(storage, {"R"}, file);
  expectShape(r, 3, 3, "R", file);
  cv::Mat t = readMatrix(storage, {"T"}, file);
  if (t.rows == 1) t = t.t();
  expectShape(t, 3, 1, "T", file);
  setPose(cameras, eigenOf(r), eigenOf(t), file + ": R", file + ": T");
  return cameras;
}

std::string writeStereo(const StereoCameras& cameras, const std::vector<std::string>& comments) {
  return storageText(cameras, comments, cv::FileStorage::FORMAT_YAML);
}

std::string storageText(const StereoCameras& cameras, const std::vector<std::string>& comments, int format) {
  const char* const name = format == cv::FileStorage::FORMAT_XML ? "stereo.xml" : "stereo.yaml";
  cv::FileStorage storage(name, cv::FileStorage::WRITE | cv::FileStorage::MEMORY | format);
  for (const std::string& comment : comments) storage.writeComment(comment);
  storage << "image_width" << cameras.size.width << "image_height" << cameras.size.height;
  writeCamera(storage, cameras.left, "1");
  writeCamera(storage, cameras.right, "2");
  storage << "R" << matOf(cameras.rotation) << "T" << matOf(cameras.translation);
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
