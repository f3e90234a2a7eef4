// Kalibr's camchain.yaml: https://github.com/ethz-asl/kalibr/wiki/yaml-formats
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "camera_formats.h"
#include "camera_storage.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr std::size_t kKalibrCoefficients = 4;  // k1 k2 p1 p2, in OpenCV's order

std::vector<double> numbersOfNode(const YamlNode& node, std::size_t count) {
  const std::vector<YamlNode> items = node.items();
  if (items.size() != count) node.fail(fmt::format("found {} numbers, expected {}", items.size(), count));
  std::vector<double> numbers;
  for (const YamlNode& item : items) numbers.push_back(item.number(kLensNumber));
  return numbers;
}

CameraIntrinsics readPinhole(const YamlNode& camera, const std::string& name) {
  camera.at("camera_model").oneOf({"pinhole"});
  const std::string lens = camera.at("distortion_model").oneOf({"radtan", "none"});
  const std::vector<double> k = numbersOfNode(camera.at("intrinsics"), 4);
  std::vector<double> d(kKalibrCoefficients, 0.0);
  if (lens == "radtan") d = numbersOfNode(camera.at("distortion_coeffs"), kKalibrCoefficients);
  return checkedCamera({k[0], 0.0, k[2], 0.0, k[1], k[3], 0.0, 0.0, 1.0}, std::move(d), name + ".intrinsics",
                       name + ".distortion_coeffs");
}

cv::Size readResolution(const YamlNode& camera) {
  const YamlNode node = camera.at("resolution");
  const std::vector<YamlNode> sides = node.items();
  if (sides.size() != 2) node.fail(fmt::format("found {} numbers, expected width and height", sides.size()));
  return {sideOf(sides[0]), sideOf(sides[1])};
}

/// x_cam1 = T x_cam0, metres.
Eigen::Matrix4d readTransform(const YamlNode& node) {
  const std::vector<YamlNode> rows = node.items();
  if (rows.size() != 4) node.fail(fmt::format("found {} rows, expected 4", rows.size()));
  Eigen::Matrix4d transform;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const std::vector<double> row = numbersOfNode(rows[i], 4);
    for (Eigen::Index j = 0; j < 4; ++j) transform(i, j) = row[j];
  }
  if (transform.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) node.fail("found another last row, expected [0, 0, 0, 1]");
  return transform;
}

std::string camchainCamera(const CameraIntrinsics& camera, cv::Size size) {
  std::vector<double> d = camera.distortion;
  d.resize(kKalibrCoefficients);
  return fmt::format(
      "  camera_model: pinhole\n  intrinsics: [{}, {}, {}, {}]\n  distortion_model: radtan\n  distortion_coeffs: "
      "[{}]\n  resolution: [{}, {}]\n",
      camera.K(0, 0), camera.K(1, 1), camera.K(0, 2), camera.K(1, 2), fmt::join(d, ", "), size.width, size.height);
}

/// Pinhole without skew, and nothing but k1 k2 p1 p2.
bool isRadtan(const CameraIntrinsics& camera) {
  const std::vector<double>& d = camera.distortion;
  return camera.K(0, 1) == 0.0 &&
         (d.size() <= kKalibrCoefficients ||
          std::all_of(d.begin() + kKalibrCoefficients, d.end(), [](double value) { return value == 0.0; }));
}

}  // namespace

StereoCameras readCamchain(const YamlNode& root, const std::string& file) {
  if (root.has("cam2")) root.at("cam2").fail("found a third camera, expected two");
  const YamlNode left = root.at("cam0"), right = root.at("cam1");
  StereoCameras cameras;
  cameras.left = readPinhole(left, file + ": cam0");
  cameras.right = readPinhole(right, file + ": cam1");
  cameras.size = readResolution(left);
  if (readResolution(right) != cameras.size) right.at("resolution").fail("found another size than that of cam0");
  const Eigen::Matrix4d transform = readTransform(right.at("T_cn_cnm1"));
  const std::string name = file + ": cam1.T_cn_cnm1";
  setPose(cameras, transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>(), name, name);
  return cameras;
}

std::optional<std::string> writeCamchain(const StereoCameras& cameras) {
  if (!isRadtan(cameras.left) || !isRadtan(cameras.right)) return std::nullopt;
  std::string text = "# Kalibr camchain: cam0 is the left camera; T_cn_cnm1 takes its points into those of cam1 [m]\n";
  text += "cam0:\n" + camchainCamera(cameras.left, cameras.size);
  text += "cam1:\n" + camchainCamera(cameras.right, cameras.size) + "  T_cn_cnm1:\n";
  const Eigen::Matrix3d& r = cameras.rotation;
  for (Eigen::Index i = 0; i < 3; ++i) {
    text += fmt::format("  - [{}, {}, {}, {}]\n", r(i, 0), r(i, 1), r(i, 2), cameras.translation[i]);
  }
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace simgap
