#include "simgap/capture/image_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr std::size_t kExposureEvery = 30;  // frames between two looks at the exposure
constexpr double kMostSaturated = 0.05;     // of an image's pixels
constexpr double kMostExposureRatio = 3.0;  // of the mean grey values
constexpr double kDarkGrey = 20.0;          // [DN] mean grey below which the ratio says nothing

/// The last number in a file's name; empty when there is none.
std::optional<long> numberIn(const std::string& name) {
  const std::string stem = std::filesystem::path(name).stem().string();
  const auto last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return std::nullopt;
  auto first = last;
  while (first > 0 && stem[first - 1] >= '0' && stem[first - 1] <= '9') --first;
  if (last - first > 15) return std::nullopt;
  return std::stol(stem.substr(first, last - first + 1));
}

void refuseTimeGoingBack(const CsvTable& table, const std::vector<double>& times) {
  for (std::size_t row = 1; row < times.size(); ++row) {
    if (!(times[row] > times[row - 1])) {
      table.fail(row, fmt::format("time does not increase: found {} s behind {} s", times[row], times[row - 1]));
    }
  }
}

}  // namespace

FrameTimes readTimes(const CsvTable& table, double max_lag) {
  FrameTimes result;
  if (!table.hasQuantity("left_time", "s")) {
    result.times = table.quantity("time", "s");
    refuseTimeGoingBack(table, result.times);
  } else {
    const std::vector<double> left = table.quantity("left_time", "s");
    const std::vector<double> right = table.quantity("right_time", "s");
    refuseTimeGoingBack(table, left);
    refuseTimeGoingBack(table, right);
    std::vector<double> lags;
    for (std::size_t row = 0; row < left.size(); ++row) {
      lags.push_back(right[row] - left[row]);
      result.times.push_back(0.5 * (left[row] + right[row]));
      if (std::abs(lags.back()) > max_lag) {
        table.fail(row, fmt::format("the right camera is {:.3g} ms behind the left one, expected at most {:.3g} ms",
                                    1e3 * lags.back(), 1e3 * max_lag));
      }
    }
    if (!lags.empty()) result.camera_lag = upperMedian(std::move(lags));
  }
  if (result.times.size() < 2) throw DataError(fmt::format("{}: expected at least two rows", table.name()));
  result.rate = static_cast<double>(result.times.size() - 1) / (result.times.back() - result.times.front());
  return result;
}

ImagePairs::ImagePairs(std::unique_ptr<ImageSource> left, std::unique_ptr<ImageSource> right, bool skip_unreadable)
    : left_(std::move(left)), right_(std::move(right)), skip_unreadable_(skip_unreadable) {
  const auto a = left_->size();
  const auto b = right_->size();
  if (a && b && *a != *b) {
    throw DataError(fmt::format("found {} left and {} right images, expected as many of both", *a, *b));
  }
}

bool ImagePairs::read(ImageSource& source, cv::Mat& image, std::string& trouble) {
  try {
    return source.next(image);
  } catch (const DataError& error) {
    trouble = error.what();
    return true;
  }
}

void ImagePairs::checkNames() {
  const auto a = numberIn(leftName());
  const auto b = numberIn(rightName());
  if (!a || !b) return;
  if (!number_offset_) number_offset_ = *b - *a;
  if (*b - *a != *number_offset_) {
    throw DataError(
        fmt::format("{} and {} stand side by side: an image of one camera is missing", leftName(), rightName()));
  }
}

void ImagePairs::checkExposure() const {
  const auto saturated = [](const cv::Mat& image) {
    return cv::countNonZero(image == 255) / static_cast<double>(image.total());
  };
  for (const auto& [image, name] : {std::pair{&left_image_, leftName()}, std::pair{&right_image_, rightName()}}) {
    const double part = saturated(*image);
    if (part > kMostSaturated) {
      throw DataError(fmt::format("{}: {:.0f} % of the pixels are saturated, expected at most {:.0f} %: overexposed",
                                  name, 100.0 * part, 100.0 * kMostSaturated));
    }
  }
  const double left = cv::mean(left_image_)[0];
  const double right = cv::mean(right_image_)[0];
  const double brighter = std::max(left, right);
  if (brighter > kDarkGrey && brighter > kMostExposureRatio * std::min(left, right)) {
    throw DataError(fmt::format("{} has a mean grey value of {:.0f}, {} of {:.0f}: expected the same exposure",
                                leftName(), left, rightName(), right));
  }
}

bool ImagePairs::next() {
  while (true) {
    std::string trouble;
    const bool left = read(*left_, left_image_, trouble);
    const bool right = read(*right_, right_image_, trouble);
    if (left != right) {
      throw DataError(
          fmt::format("the {} camera has only {} images, the other one has more", left ? "right" : "left", read_));
    }
    if (!left) return false;
    frame_ = read_++;
    checkNames();
    if (trouble.empty()) break;
    if (!skip_unreadable_) throw DataError(trouble + " (--skip-unreadable goes on without it)");
    skipped_.push_back(trouble);
  }
  if (left_image_.size() != right_image_.size()) {
    throw DataError(fmt::format("{} is {}x{} px, {} is {}x{} px: expected the same size", leftName(), left_image_.cols,
                                left_image_.rows, rightName(), right_image_.cols, right_image_.rows));
  }
  if (frame_ % kExposureEvery == 0) checkExposure();
  return true;
}

}  // namespace simgap
