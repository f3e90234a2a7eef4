#include "simgap/capture/camera_files.h"

#include <fmt/format.h>

#include "camera_formats.h"
#include "camera_storage.h"
#include "simgap/core/error.h"
#include "simgap/core/yaml.h"

namespace simgap {
namespace {

constexpr std::size_t kLargestCalibration = std::size_t{1} << 20U;  // [bytes]; such files have a few thousand

StereoCameras readOne(const CameraFile& file) {
  const std::size_t first = file.text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && file.text[first] == '<') return readStereoXml(file);
  const YamlNode root = parseCameraYaml(file.text, file.name);
  if (root.isMap() && root.has("cam0")) return readCamchain(root, file.name);
  if (root.isMap() && root.has("camera_matrix") && root.has("distortion_coefficients")) {
    throw ConfigError(
        fmt::format("{}: found the camera_info of one camera, expected that of the other one, too: "
                    "--cameras LEFT RIGHT",
                    file.name));
  }
  if (!isStereoYaml(file.text)) {
    throw ConfigError(
        fmt::format("{}: found no calibration of two cameras, expected OpenCV's file storage (%YAML:1.0 or "
                    "XML), Kalibr's camchain (cam0, cam1), or two files of camera_info",
                    file.name));
  }
  return stereoFromYaml(root, file.name);
}

}  // namespace

StereoCameras readCameras(std::span<const CameraFile> files) {
  for (const CameraFile& file : files) {
    if (file.text.size() <= kLargestCalibration) continue;
    throw ConfigError(fmt::format("{}: found {} bytes, expected a calibration of at most {}", file.name,
                                  file.text.size(), kLargestCalibration));
  }
  if (files.size() == 1) return readOne(files[0]);
  if (files.size() != 2) throw ConfigError(fmt::format("found {} files of cameras, expected 1 or 2", files.size()));
  return readCameraInfo({parseCameraYaml(files[0].text, files[0].name), parseCameraYaml(files[1].text, files[1].name)},
                        {files[0].name, files[1].name});
}

}  // namespace simgap
