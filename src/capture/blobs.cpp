#include "simgap/capture/blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "simgap/core/error.h"
#include "touching_blobs.h"

namespace simgap {
namespace {

constexpr double kRimExcess = 0.5;  // [px] by which the rim's window reaches beyond the margin; see below
constexpr int kCentringRounds = 4;  // of re-centring; the second already moves by less than 1e-3 px

/// Pixels between two boxes; 0 when they touch.
double gapBetween(const cv::Rect& a, const cv::Rect& b) {
  const int x = std::max({a.x - (b.x + b.width), b.x - (a.x + a.width), 0});
  const int y = std::max({a.y - (b.y + b.height), b.y - (a.y + a.height), 0});
  return std::hypot(x, y);
}

struct Moments {
  double mass = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
};

/// Moments of intensity above the background within a circle, about its centre.
Moments momentsWithin(const cv::Mat& image, const Eigen::Vector2d& centre, double radius, double background) {
  Moments m;
  const int top = std::max(0, static_cast<int>(std::ceil(centre.y() - radius)));
  const int bottom = std::min(image.rows - 1, static_cast<int>(std::floor(centre.y() + radius)));
  for (int y = top; y <= bottom; ++y) {
    const double dy = y - centre.y();
    const double half = std::sqrt(std::max(0.0, radius * radius - dy * dy));
    const int first = std::max(0, static_cast<int>(std::ceil(centre.x() - half)));
    const int last = std::min(image.cols - 1, static_cast<int>(std::floor(centre.x() + half)));
    const auto* row = image.ptr<unsigned char>(y);
    for (int x = first; x <= last; ++x) {
      const double w = row[x] - background;
      const double dx = x - centre.x();
      m.mass += w;
      m.x += w * dx;
      m.y += w * dy;
      m.xx += w * dx * dx;
      m.xy += w * dx * dy;
      m.yy += w * dy * dy;
    }
  }
  return m;
}

/// One Newton step of the centre towards the point about which the rim is balanced: sum I g(rho) x / rho = 0, with a
/// window g on the rim. Up to a factor this is the maximum-likelihood position of a disc of any profile in white noise:
/// only where the intensity falls does a pixel tell of the position, the others bring noise. A window of +-2.5 px
/// covers a rim blurred by 0.7 px; a narrower one (+-2 px) lets the pixel grid bias the centre by 0.005 px.
Eigen::Vector2d rimStep(const cv::Mat& image, const Eigen::Vector2d& centre, double radius, double width,
                        double background) {
  Eigen::Vector2d balance = Eigen::Vector2d::Zero();
  double gain_x = 0.0;
  double gain_y = 0.0;
  const double reach = radius + width;
  const int top = std::max(0, static_cast<int>(std::ceil(centre.y() - reach)));
  const int bottom = std::min(image.rows - 1, static_cast<int>(std::floor(centre.y() + reach)));
  const int left = std::max(0, static_cast<int>(std::ceil(centre.x() - reach)));
  const int right = std::min(image.cols - 1, static_cast<int>(std::floor(centre.x() + reach)));
  for (int y = top; y <= bottom; ++y) {
    const auto* row = image.ptr<unsigned char>(y);
    const double dy = y - centre.y();
    for (int x = left; x <= right; ++x) {
      const double dx = x - centre.x();
      const double rho = std::sqrt(dx * dx + dy * dy);
      const double u = (rho - radius) / width;
      if (std::abs(u) >= 1.0) continue;
      const double intensity = row[x] - background;
      const double bell = 1.0 - u * u;
      const double g = bell * bell / rho;                          // g / rho
      const double slope = -4.0 * u * bell / width / (rho * rho);  // g' / rho^2
      balance += intensity * g * Eigen::Vector2d(dx, dy);
      gain_x -= intensity * (slope * dx * dx + g * dy * dy / (rho * rho));
      gain_y -= intensity * (slope * dy * dy + g * dx * dx / (rho * rho));
    }
  }
  if (!(gain_x < 0.0 && gain_y < 0.0)) return Eigen::Vector2d::Zero();
  return {-balance.x() / gain_x, -balance.y() / gain_y};
}

/// Smaller by larger axis of the ellipse with these second moments.
double axisRatio(const Eigen::Matrix2d& m) {
  const double mean = 0.5 * m.trace();
  const double spread = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  return mean - spread > 0.0 ? std::sqrt((mean - spread) / (mean + spread)) : 0.0;
}

}  // namespace

BlobDetector::BlobDetector(const BlobOptions& options)
    : options_(options), touching_(std::make_unique<TouchingBlobs>()) {}

BlobDetector::~BlobDetector() = default;

double BlobDetector::backgroundAround(const cv::Mat& image, const cv::Rect& box) {
  const cv::Rect wide(box.x - options_.border, box.y - options_.border, box.width + 2 * options_.border,
                      box.height + 2 * options_.border);
  rim_.clear();
  for (int x = wide.x; x < wide.x + wide.width; ++x) {
    rim_.push_back(image.at<unsigned char>(wide.y, x));
    rim_.push_back(image.at<unsigned char>(wide.y + wide.height - 1, x));
  }
  for (int y = wide.y + 1; y + 1 < wide.y + wide.height; ++y) {
    rim_.push_back(image.at<unsigned char>(y, wide.x));
    rim_.push_back(image.at<unsigned char>(y, wide.x + wide.width - 1));
  }
  // A mean of the middle half: a median of integers would be off by up to half a grey value.
  std::sort(rim_.begin(), rim_.end());
  double background = 0.0;
  const std::size_t quarter = rim_.size() / 4;
  for (std::size_t i = quarter; i < rim_.size() - quarter; ++i) background += rim_[i];
  background /= static_cast<double>(rim_.size() - 2 * quarter);
  return background;
}

bool BlobDetector::measure(const cv::Mat& image, BrightRegion& region) const {
  const cv::Rect& box = region.box;
  Blob& blob = region.blob;
  double peak = 0.0;
  for (int y = box.y; y < box.y + box.height; ++y) {
    const auto* row = image.ptr<unsigned char>(y);
    peak = std::max<double>(peak, *std::max_element(row + box.x, row + box.x + box.width));
  }
  region.peak = peak - region.background;
  const double half = 0.5 * (region.background + peak);
  for (int y = box.y; y < box.y + box.height; ++y) {
    const auto* row = image.ptr<unsigned char>(y);
    blob.area +=
        static_cast<double>(std::count_if(row + box.x, row + box.x + box.width, [&](int v) { return v > half; }));
  }
  if (blob.area < options_.min_area) return false;
  blob.centre = {box.x + 0.5 * (box.width - 1), box.y + 0.5 * (box.height - 1)};
  const double radius = 0.5 * std::max(box.width, box.height) + region.margin;
  Moments moments;
  for (int round = 0; round < kCentringRounds; ++round) {
    moments = momentsWithin(image, blob.centre, radius, region.background);
    if (!(moments.mass > 0.0)) return true;
    const Eigen::Vector2d step(moments.x / moments.mass, moments.y / moments.mass);
    blob.centre += step;
    if (step.norm() < 1e-3) break;
  }
  region.moments << moments.xx, moments.xy, moments.xy, moments.yy;
  region.moments /= moments.mass;
  const Eigen::Vector2d centre_of_mass = blob.centre;
  const double rim = std::sqrt(blob.area / std::numbers::pi);
  const double width = region.margin + kRimExcess;
  for (int round = 0; rim > width && round < kCentringRounds; ++round) {
    const Eigen::Vector2d step = rimStep(image, blob.centre, rim, width, region.background);
    blob.centre += step;
    if (step.norm() < 1e-3) break;
  }
  region.asymmetry = (blob.centre - centre_of_mass).norm();
  blob.circularity = axisRatio(region.moments);
  const bool inside = blob.centre.x() >= box.x && blob.centre.x() < box.x + box.width && blob.centre.y() >= box.y &&
                      blob.centre.y() < box.y + box.height;
  region.round = blob.circularity >= options_.min_circularity && inside;
  return true;
}

void BlobDetector::findRegions(const cv::Mat& image) {
  cv::threshold(image, binary_, options_.threshold, 255, cv::THRESH_BINARY);
  cv::findContours(binary_, contours_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  regions_.clear();
  for (const auto& contour : contours_) {
    const cv::Rect box = cv::boundingRect(contour);
    if (box.area() < 4) continue;  // a hot pixel
    const int border = options_.border;
    if (box.x < border || box.y < border || box.x + box.width > image.cols - border ||
        box.y + box.height > image.rows - border) {
      ++rejections_.edge;
    } else if (box.area() > 2.0 * options_.max_area) {
      ++rejections_.area;
    } else {
      regions_.emplace_back().box = box;
    }
  }
  if (regions_.size() > kMostBlobs) {
    throw DataError(fmt::format("found {} bright blobs, expected at most {}: is the image overexposed?",
                                regions_.size(), kMostBlobs));
  }
  for (BrightRegion& region : regions_) {
    region.margin = kWindowMargin;
    for (const BrightRegion& other : regions_) {
      if (&other != &region) region.margin = std::min(region.margin, 0.5 * gapBetween(region.box, other.box));
    }
  }
}

const std::vector<Blob>& BlobDetector::detect(const cv::Mat& image, double expected_radius) {
  CV_Assert(image.type() == CV_8UC1);
  blobs_.clear();
  rejections_ = {};
  findRegions(image);
  const auto too_small = [&](BrightRegion& region) {
    region.background = backgroundAround(image, region.box);
    return !measure(image, region);
  };
  const auto kept = std::remove_if(regions_.begin(), regions_.end(), too_small);
  rejections_.area += static_cast<int>(regions_.end() - kept);
  regions_.erase(kept, regions_.end());
  rejections_.circularity += touching_->separate(image, regions_, expected_radius, blobs_);
  return blobs_;
}

}  // namespace simgap
