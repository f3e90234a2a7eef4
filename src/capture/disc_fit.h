/// \file
/// Discs fitted to the pixels of an image: what tells markers that touch in it from one another.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace simgap {

/// The image of a lit sphere: brightness amplitude Phi((radius - rho) / blur) (1 - fade rho^2 / radius^2) at the
/// distance rho from its centre, Phi the normal distribution. [px], [DN]
struct Disc {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0.0;
  double amplitude = 0.0;
};

/// What is known of a disc before its pixels are looked at: means and standard deviations.
struct DiscShape {
  double radius = 0.0, radius_sd = 0.0;        ///< [px]
  double amplitude = 0.0, amplitude_sd = 0.0;  ///< [DN]
  double blur = 0.8, blur_sd = 0.4;            ///< [px]
  double fade = 0.2, fade_sd = 0.3;            ///< (1)
  double noise = 3.0;                          ///< [DN] standard deviation of a pixel about the model
};

struct DiscFit {
  bool converged = false;
  std::vector<Disc> discs;  ///< the first hides the others, the second the third, …
  double background = 0.0;  ///< [DN]
  double blur = 0.0, fade = 0.0;
  double misfit = 0.0;            ///< mean square of the pixels' residuals by that of `noise`
  Eigen::Vector2d excess{0, 0};   ///< [px] where the image is most above the model
  double excess_height = 0.0;     ///< [DN] by how much, in the mean of 3x3 pixels
  std::vector<double> centre_sd;  ///< shape (discs) [px], along the less certain direction
};

constexpr std::size_t kMostDiscs = 4;

/// Levenberg-Marquardt over background, blur, fade and each disc's centre, radius and amplitude, on the pixels within
/// kDiscRim of a disc; `shape` enters as Gaussian priors.
/// \param start  1 to kMostDiscs discs, the front one first
DiscFit fitDiscs(const cv::Mat& image, const DiscShape& shape, const std::vector<Disc>& start, double background);
constexpr double kDiscRim = 3.0;  ///< [px] beyond a disc's radius: where its blurred rim has faded

}  // namespace simgap
