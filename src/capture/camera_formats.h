/// \file
/// One reader per notation, for readCameras.
#pragma once

#include <array>
#include <string>

#include "simgap/capture/camera_files.h"
#include "simgap/core/yaml.h"

namespace simgap {

StereoCameras readCamchain(const YamlNode& root, const std::string& file);
/// \param roots  of the left camera and the right one
StereoCameras readCameraInfo(const std::array<YamlNode, 2>& roots, const std::array<std::string, 2>& files);
StereoCameras readStereoXml(const CameraFile& file);

}  // namespace simgap
