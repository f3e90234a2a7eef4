/// \file
/// Two image sources side by side, with the time of every pair; refuses what does not belong together.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "simgap/capture/images.h"
#include "simgap/core/csv.h"

namespace simgap {

/// When each pair was taken.
struct FrameTimes {
  std::vector<double> times;  ///< [s]; empty: `rate` counts
  double rate = 0.0;          ///< [Hz]
  double camera_lag = 0.0;    ///< [s] median of right - left, when the file tells both
  double at(std::size_t frame) const { return times.empty() ? static_cast<double>(frame) / rate : times[frame]; }
};

/// Columns `time_s`, or `left_time_s` and `right_time_s` (their mean is used).
/// \param max_lag  [s] of one camera behind the other.
/// \throws DataError: time that does not increase, cameras further apart than max_lag, and all that CsvTable refuses.
FrameTimes readTimes(const CsvTable& table, double max_lag);

class ImagePairs {
 public:
  /// \param skip_unreadable  go on behind a pair of which an image cannot be read, and count it.
  /// \throws DataError when the two do not hold equally many images.
  ImagePairs(std::unique_ptr<ImageSource> left, std::unique_ptr<ImageSource> right, bool skip_unreadable);

  /// The next pair; false at the end.
  /// \throws DataError: an image that cannot be read, different sizes, numbers in the names that drift apart (an image
  ///         is missing), one camera without images before the other, overexposed or differently exposed images.
  bool next();

  const cv::Mat& left() const { return left_image_; }
  const cv::Mat& right() const { return right_image_; }
  std::string leftName() const { return left_->name(); }
  std::string rightName() const { return right_->name(); }
  std::size_t frame() const { return frame_; }                       ///< number of this pair, from 0
  std::optional<std::size_t> size() const { return left_->size(); }  ///< pairs in all, when known
  const std::vector<std::string>& skipped() const { return skipped_; }

 private:
  bool read(ImageSource& source, cv::Mat& image, std::string& trouble);
  void checkNames();
  void checkExposure() const;

  std::unique_ptr<ImageSource> left_, right_;
  bool skip_unreadable_;
  cv::Mat left_image_, right_image_;
  std::size_t read_ = 0;
  std::size_t frame_ = 0;
  std::optional<long> number_offset_;
  std::vector<std::string> skipped_;
};

}  // namespace simgap
