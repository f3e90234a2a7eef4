/// \file
/// Infrared stereo images as a physicist would draw them: a sphere is seen wherever a pixel's ray, bent back through
/// the lens, meets it; then blur, light and electronics. Makes the images on which the capture is judged, and shares no
/// code with it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace simgap::reality {

/// Pinhole with radial (k1, k2) and tangential (p1, p2) distortion.
struct Lens {
  int width = 640;
  int height = 480;
  double fx = 800.0, fy = 800.0, cx = 320.0, cy = 240.0;  ///< [px]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;

  Eigen::Vector2d project(const Eigen::Vector3d& point) const;  ///< [px]; the centre of pixel (0, 0) is (0, 0)
  Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;      ///< through the pixel, z = 1
};

/// Two cameras; x_right = rotation x_left + translation.
struct StereoLenses {
  Lens left;
  Lens right;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]
};

/// f = 800 px at 640x480 (`scale` 1) or 1600 px at 1280x960 (2), baseline 0.35 m, cameras turned inwards by 14 deg.
StereoLenses standardLenses(int scale = 1);
/// The cameras as an OpenCV file.
std::string stereoYaml(const StereoLenses& lenses);

/// A lit sphere; with brightness 0 it hides what is behind it.
struct Sphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< in the camera's frame [m]
  double radius = 0.006;                             ///< [m]
  double brightness = 1.0;                           ///< relative to Light::peak
};

/// A reflection on the sensor.
struct Spot {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1.5;  ///< [px]
  double peak = 150;   ///< [DN]
};

struct Light {
  double peak = 200.0;       ///< [DN] centre of a marker; above 255 it saturates
  double background = 8.0;   ///< [DN]
  double blur = 0.7;         ///< [px] standard deviation
  double read_noise = 2.0;   ///< [DN]
  double shot_noise = 0.02;  ///< variance per signal [DN^2 / DN]
};

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  void writePgm(const std::filesystem::path& file) const;
};

/// One camera. Building it inverts the lens for every pixel once.
class Camera {
 public:
  Camera(const Lens& lens, const Light& light);
  /// \param exposures  the spheres at moments spread evenly over the exposure; more than one gives motion blur.
  Image render(const std::vector<std::vector<Sphere>>& exposures, const std::vector<Spot>& spots,
               std::uint64_t seed) const;

 private:
  void draw(const Sphere& sphere, std::vector<float>& light) const;

  Lens lens_;
  Light light_;
  std::vector<Eigen::Vector2f> rays_;  ///< undistorted x / z, y / z of every pixel
};

}  // namespace simgap::reality
