/// \file
/// Bright round blobs of an infrared image and their centres.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace simgap {

struct BlobOptions {
  int threshold = 50;            ///< [DN] above it a pixel may belong to a marker
  double min_area = 6.0;         ///< [px] of pixels above half the blob's height
  double max_area = 3000.0;      ///< [px]
  double min_circularity = 0.7;  ///< smaller by larger axis of the blob's second moments
  int border = 3;                ///< [px] a blob nearer to the image's edge is cut off
};

struct Blob {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< [px]; the centre of pixel (0, 0) is (0, 0)
  double area = 0.0;                                 ///< [px]
  double circularity = 0.0;
  double spread = 1.0;  ///< standard deviation of the centre by that of a marker that stands free in the same image
};

/// What was bright but no marker.
struct BlobRejections {
  int area = 0;
  int circularity = 0;
  int edge = 0;
};

/// A bright region of an image, before it is known whether it is one marker.
struct BrightRegion {
  cv::Rect box;
  double margin = 0.0;      ///< [px] to its neighbour's half of the gap, at most what a blurred rim needs
  double background = 0.0;  ///< [DN]
  double peak = 0.0;        ///< [DN] above the background
  Blob blob;
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();  ///< second moments of its intensity about the centre [px^2]
  double asymmetry = 0.0;                             ///< [px] centre of the rim from the centre of mass
  bool round = false;
};

class TouchingBlobs;

/// Finds blobs with a buffer that it keeps from image to image.
class BlobDetector {
 public:
  explicit BlobDetector(const BlobOptions& options = {});
  ~BlobDetector();
  /// Threshold, contours, then around each contour a circular window: background = median of the window's rim,
  /// centre = intensity-weighted mean above the background, window re-centred until it rests, then moved to where the
  /// rim is balanced (half the variance of the mean). Regions that touch or nearly touch, are not round or not
  /// symmetrical are then taken for several markers and told apart (TouchingBlobs).
  /// \param image  8-bit grey.
  /// \param expected_radius  [px] of a marker, where targets were seen already; 0: not known.
  /// \throws DataError when more than kMostBlobs are found (overexposed).
  const std::vector<Blob>& detect(const cv::Mat& image, double expected_radius = 0.0);
  const BlobRejections& rejections() const { return rejections_; }

  static constexpr std::size_t kMostBlobs = 400;

 private:
  void findRegions(const cv::Mat& image);
  /// Of the rim of the widened box, whose middle half is blind to a neighbour that reaches in. [DN]
  double backgroundAround(const cv::Mat& image, const cv::Rect& box);
  /// \returns false when it is too small.
  bool measure(const cv::Mat& image, BrightRegion& region) const;

  BlobOptions options_;
  cv::Mat binary_;
  std::vector<std::vector<cv::Point>> contours_;
  std::vector<BrightRegion> regions_;
  std::vector<unsigned char> rim_;
  std::vector<Blob> blobs_;
  BlobRejections rejections_;
  std::unique_ptr<TouchingBlobs> touching_;
};

}  // namespace simgap
