/// \file
/// What readers of camera calibrations share: numbers that a lens can have, and the checks of two cameras.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "simgap/capture/stereo_cameras.h"
#include "simgap/core/yaml.h"

namespace simgap {

constexpr Range kLensNumber{-1e9, 1e9, false, "a number of a size of at most 1e9"};
constexpr long kMostPixels = 1 << 16;   // of a side of an image
constexpr long kMostStorageRows = 100;  // of a matrix in a file, and columns

/// \name As opencv2/core/eigen.hpp has them, which brings half of Eigen along.
///@{
Eigen::MatrixXd eigenOf(const cv::Mat& matrix);
cv::Mat matOf(const Eigen::MatrixXd& matrix);
///@}

/// A file of OpenCV's FileStorage, in YAML or XML.
class CameraStorage {
 public:
  virtual ~CameraStorage() = default;
  /// Empty when nothing has that name. \throws ConfigError: no matrix
  virtual std::optional<cv::Mat> matrix(const std::string& name) const = 0;
  /// A side of the images in pixels; 0 when the file does not say.
  virtual int side(const std::string& name) const = 0;
};

/// \throws ConfigError as readStereo
StereoCameras stereoFrom(const CameraStorage& storage, const std::string& file);
/// The same of YAML that was read. \param root  by parseCameraYaml
StereoCameras stereoFromYaml(const YamlNode& root, const std::string& file);
/// YAML whose first line may be the directive of OpenCV, which YAML does not have.
YamlNode parseCameraYaml(const std::string& text, const std::string& file);

/// A matrix node of FileStorage YAML: rows, cols, data. \throws ConfigError
cv::Mat matrixOf(const YamlNode& node);
/// The width or height of a file. \throws ConfigError
int sideOf(const YamlNode& node);

/// `where` stands for K and D in errors: "s.yaml: cam0". \throws ConfigError: focal lengths not above 0, a lens of no
/// model
CameraIntrinsics checkedCamera(const cv::Matx33d& k, std::vector<double> distortion, const std::string& k_name,
                               const std::string& d_name);
/// Sets x_right = r x_left + t; r is normalized. \throws ConfigError: no rotation, no distance
void setPose(StereoCameras& cameras, const Eigen::Matrix3d& r, const Eigen::Vector3d& t, const std::string& r_name,
             const std::string& t_name);

/// FileStorage's text. \param format  cv::FileStorage::FORMAT_YAML or FORMAT_XML
std::string storageText(const StereoCameras& cameras, const std::vector<std::string>& comments, int format);

}  // namespace simgap
