/// \file
/// Bright regions to markers: what stands free is one marker, what touches is told apart.
#pragma once

#include <optional>
#include <vector>

#include "disc_fit.h"
#include "simgap/capture/blobs.h"

namespace simgap {

constexpr double kWindowMargin = 2.0;  // [px] beyond the thresholded blob: where its blurred rim has faded

/// What one marker looks like in the images of a camera, and who stands too close to be measured alone.
class TouchingBlobs {
 public:
  /// Regions that stand free, are round and symmetrical become blobs as they are; they also say what the image of one
  /// marker looks like. Groups of the others are fitted by one to kMostDiscs such images (fitDiscs). A group that none
  /// of them explains keeps its round regions, with the deviation that their asymmetry speaks of.
  /// \param expected_radius  [px] of a marker; 0: not known, the median of the free regions is taken
  /// \returns how many regions were no marker.
  int separate(const cv::Mat& image, const std::vector<BrightRegion>& regions, double expected_radius,
               std::vector<Blob>& blobs);

 private:
  void learn(const cv::Mat& image, std::vector<const BrightRegion*> free, double area);
  std::optional<DiscFit> explain(const cv::Mat& image, const std::vector<const BrightRegion*>& group) const;
  int separateGroup(const cv::Mat& image, const std::vector<const BrightRegion*>& group,
                    std::vector<Blob>& blobs) const;

  std::optional<DiscShape> marker_;  ///< as the last free ones looked
  double centre_sd_ = 0.0;           ///< [px] of a free marker, by the same fit
  int age_ = 0;                      ///< images since then
};

}  // namespace simgap
