/// \file
/// Where images come from: a folder, a video. (Cameras that run: live_cameras.h.)
#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace simgap {

/// A sequence of 8-bit grey images.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  /// How many there are; empty when the source cannot tell (a camera).
  virtual std::optional<std::size_t> size() const = 0;
  /// The next image into `image`; false at the end. \throws DataError when it cannot be read; the next call then goes
  /// on behind it.
  virtual bool next(cv::Mat& image) = 0;
  /// Of the image that `next` gave or failed at: "left/00012.png", "left.avi, frame 12".
  virtual std::string name() const = 0;
};

/// A folder (its image files in the order of their names) or a video file. Colour is turned into grey.
/// \throws ConfigError when it is neither; DataError when it holds no image.
std::unique_ptr<ImageSource> openImages(const std::filesystem::path& path);

/// The image as PNG bytes.
std::string encodePng(const cv::Mat& image);

}  // namespace simgap
