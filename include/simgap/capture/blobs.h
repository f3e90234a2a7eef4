/// \file
/// Bright round blobs of an infrared image and their centres.
#pragma once

#include <Eigen/Core>
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
};

/// What was bright but no marker.
struct BlobRejections {
  int area = 0;
  int circularity = 0;
  int edge = 0;
};

/// Finds blobs with a buffer that it keeps from image to image.
class BlobDetector {
 public:
  explicit BlobDetector(const BlobOptions& options = {}) : options_(options) {}
  /// Threshold, contours, then around each contour a circular window: background = median of the window's rim,
  /// centre = intensity-weighted mean above the background, window re-centred until it rests, then moved to where the
  /// rim is balanced (half the variance of the mean).
  /// \param image  8-bit grey.  \throws DataError when more than kMostBlobs are found (overexposed).
  const std::vector<Blob>& detect(const cv::Mat& image);
  const BlobRejections& rejections() const { return rejections_; }

  static constexpr std::size_t kMostBlobs = 400;

 private:
  /// Of the rim of the widened box, whose middle half is blind to a neighbour that reaches in. [DN]
  double backgroundAround(const cv::Mat& image, const cv::Rect& box);
  void measure(const cv::Mat& image, const cv::Rect& box, double margin);

  BlobOptions options_;
  cv::Mat binary_;
  std::vector<std::vector<cv::Point>> contours_;
  std::vector<cv::Rect> boxes_;
  std::vector<unsigned char> rim_;
  std::vector<Blob> blobs_;
  BlobRejections rejections_;
};

}  // namespace simgap
