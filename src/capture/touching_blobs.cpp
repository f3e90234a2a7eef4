#include "touching_blobs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kFreeAsymmetry = 0.15;  // [px] of a region that is one marker: noise moves it by 0.03
constexpr double kFreeCircularity = 0.92;
constexpr double kFreeArea = 1.25;         // by the median of the free ones
constexpr std::size_t kReferences = 5;     // free regions whose image is fitted
constexpr double kRadiusSpread = 0.06;     // (1) of the markers in one image: they stand at different depths
constexpr double kAmplitudeSpread = 0.15;  // (1)
constexpr double kMostMisfit = 4.0;        // of a group's pixels by that of free markers
constexpr double kBlurSpread = 0.1;        // [px]
constexpr double kFadeSpread = 0.05;       // (1)
constexpr int kOldest = 60;                // images for which a marker's looks are remembered
constexpr double kOtherArea = 0.3;         // (1) by which the expected area may differ from the remembered one
constexpr double kFarArea = 0.7;           // (1) of a marker that is further away than those that were looked at
constexpr double kHiddenPart = 1.3;        // (1) of a marker's area may be hidden in a group, with what the rim adds
constexpr double kLeastBrightness = 0.6;   // (1) of a region's peak, by the height of a marker's image
constexpr double kMostBrightness = 1.6;
constexpr int kClusterRounds = 5;
constexpr double kMostSpread = 5.0;  // by which a centre may be less certain than a free one's

bool isSymmetrical(const BrightRegion& region) {
  return region.round && region.asymmetry < kFreeAsymmetry && region.blob.circularity > kFreeCircularity;
}

bool standsFree(const BrightRegion& region) { return isSymmetrical(region) && region.margin >= kWindowMargin; }

template <typename Value>
double medianOf(const std::vector<DiscFit>& fits, const Value& value) {
  std::vector<double> values;
  for (const DiscFit& fit : fits) values.push_back(value(fit));
  return upperMedian(std::move(values));
}

double medianArea(const std::vector<const BrightRegion*>& regions) {
  std::vector<double> areas;
  for (const BrightRegion* region : regions) areas.push_back(region->blob.area);
  return upperMedian(std::move(areas));
}

/// Regions whose windows reach into one another.
std::vector<std::vector<const BrightRegion*>> groupsOf(const std::vector<const BrightRegion*>& regions) {
  std::vector<std::vector<const BrightRegion*>> groups;
  std::vector<char> taken(regions.size(), 0);
  const auto near = [](const BrightRegion& a, const BrightRegion& b) {
    const int reach = static_cast<int>(2.0 * kWindowMargin);
    const cv::Rect wide(a.box.x - reach, a.box.y - reach, a.box.width + 2 * reach, a.box.height + 2 * reach);
    return (wide & b.box).area() > 0;
  };
  for (std::size_t first = 0; first < regions.size(); ++first) {
    if (taken[first]) continue;
    taken[first] = 1;
    std::vector<const BrightRegion*>& group = groups.emplace_back(1, regions[first]);
    for (std::size_t member = 0; member < group.size(); ++member) {
      for (std::size_t i = first + 1; i < regions.size(); ++i) {
        if (taken[i] || !near(*group[member], *regions[i])) continue;
        taken[i] = 1;
        group.push_back(regions[i]);
      }
    }
  }
  return groups;
}

/// One disc per region, two where it is long: their second moments then say how far apart they are.
std::vector<Disc> startOf(const std::vector<const BrightRegion*>& group, const DiscShape& shape) {
  std::vector<Disc> discs;
  for (const BrightRegion* region : group) {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(region->moments);
    const double apart = std::sqrt(std::max(0.0, axes.eigenvalues()[1] - axes.eigenvalues()[0]));
    const Disc disc{region->blob.centre, shape.radius, shape.amplitude};
    discs.push_back(disc);
    if (apart < 0.25 * shape.radius) continue;
    discs.back().centre -= apart * axes.eigenvectors().col(1);
    discs.push_back(disc);
    discs.back().centre += apart * axes.eigenvectors().col(1);
  }
  return discs;
}

/// So many discs where the group's bright pixels crowd: k-means from the pixels that are furthest from one another.
std::vector<Disc> clusteredStart(const cv::Mat& image, const std::vector<const BrightRegion*>& group, std::size_t count,
                                 const DiscShape& shape) {
  std::vector<Eigen::Vector2d> pixels;
  for (const BrightRegion* region : group) {
    const double half = region->background + 0.5 * region->peak;
    for (int y = region->box.y; y < region->box.y + region->box.height; ++y) {
      for (int x = region->box.x; x < region->box.x + region->box.width; ++x) {
        if (image.at<unsigned char>(y, x) > half) pixels.emplace_back(x, y);
      }
    }
  }
  if (pixels.size() < count) return {};
  std::vector<Eigen::Vector2d> centres{group.front()->blob.centre};
  const auto nearest = [&](const Eigen::Vector2d& pixel) {
    return std::min_element(centres.begin(), centres.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return (a - pixel).squaredNorm() < (b - pixel).squaredNorm();
    });
  };
  const auto farthest = [&] {
    return *std::max_element(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return (*nearest(a) - a).squaredNorm() < (*nearest(b) - b).squaredNorm();
    });
  };
  centres.front() = farthest();  // an end of the group
  while (centres.size() < count) centres.push_back(farthest());
  for (int round = 0; round < kClusterRounds; ++round) {
    std::vector<Eigen::Vector3d> sums(count, Eigen::Vector3d::Zero());  // x, y, pixels
    for (const Eigen::Vector2d& pixel : pixels) sums[nearest(pixel) - centres.begin()] += pixel.homogeneous();
    for (std::size_t k = 0; k < count; ++k) {
      if (sums[k].z() > 0.0) centres[k] = sums[k].hnormalized();
    }
  }
  std::vector<Disc> discs;
  for (const Eigen::Vector2d& centre : centres) discs.push_back({centre, shape.radius, shape.amplitude});
  return discs;
}

/// How many markers a group can be at most. What is symmetrical, or of another brightness than markers, is one thing.
std::size_t mostDiscs(const std::vector<const BrightRegion*>& group, const DiscShape& marker) {
  const double single = kFarArea * std::numbers::pi * marker.radius * marker.radius;
  double most = 0.0;
  for (const BrightRegion* region : group) {
    const double brightness = region->peak / marker.amplitude;
    const bool one = isSymmetrical(*region) || brightness < kLeastBrightness || brightness > kMostBrightness;
    most += one ? 1.0 : std::max(1.0, std::floor(region->blob.area / single + kHiddenPart));
  }
  return static_cast<std::size_t>(std::min<double>(kMostDiscs, most));
}

}  // namespace

void TouchingBlobs::learn(const cv::Mat& image, std::vector<const BrightRegion*> free, double area) {
  std::stable_sort(free.begin(), free.end(), [area](const BrightRegion* a, const BrightRegion* b) {
    return std::abs(a->blob.area - area) < std::abs(b->blob.area - area);
  });
  if (free.size() > kReferences) free.resize(kReferences);
  std::vector<DiscFit> fits;
  for (const BrightRegion* region : free) {
    const double radius = std::sqrt(region->blob.area / std::numbers::pi);
    DiscShape unknown;
    unknown.radius = unknown.radius_sd = radius;
    unknown.amplitude = unknown.amplitude_sd = region->peak;
    unknown.noise = 1.0;
    DiscFit fit = fitDiscs(image, unknown, {{region->blob.centre, radius, region->peak}}, region->background);
    if (fit.converged) fits.push_back(std::move(fit));
  }
  if (fits.empty()) return;
  DiscShape shape;
  shape.radius = medianOf(fits, [](const DiscFit& f) { return f.discs[0].radius; });
  shape.amplitude = medianOf(fits, [](const DiscFit& f) { return f.discs[0].amplitude; });
  shape.blur = medianOf(fits, [](const DiscFit& f) { return f.blur; });
  shape.fade = medianOf(fits, [](const DiscFit& f) { return f.fade; });
  shape.noise = std::sqrt(medianOf(fits, [](const DiscFit& f) { return f.misfit; }));
  shape.radius_sd = kRadiusSpread * shape.radius;
  shape.amplitude_sd = kAmplitudeSpread * shape.amplitude;
  shape.blur_sd = kBlurSpread;
  shape.fade_sd = kFadeSpread;
  marker_ = shape;
  centre_sd_ = medianOf(fits, [](const DiscFit& f) { return f.centre_sd[0]; });
  age_ = 0;
}

/// More discs, where the image is brightest above them, until they explain the group.
std::optional<DiscFit> TouchingBlobs::explain(const cv::Mat& image,
                                              const std::vector<const BrightRegion*>& group) const {
  const std::size_t most = mostDiscs(group, *marker_);
  std::vector<Disc> start = startOf(group, *marker_);
  const auto explains = [](const DiscFit& fit) { return fit.converged && fit.misfit < kMostMisfit; };
  while (start.size() <= most) {
    DiscFit fit = fitDiscs(image, *marker_, start, group.front()->background);
    if (explains(fit)) return fit;
    if (start.size() > 1) {
      // Moments and excess mislead where three or more touch, or one is much darker.
      const std::vector<Disc> clustered = clusteredStart(image, group, start.size(), *marker_);
      if (clustered.empty()) break;
      const DiscFit other = fitDiscs(image, *marker_, clustered, group.front()->background);
      if (explains(other)) return other;
      if (other.misfit < fit.misfit) fit = other;
    }
    if (fit.discs.empty()) break;
    start = fit.discs;
    start.push_back({fit.excess, marker_->radius, marker_->amplitude});
  }
  return std::nullopt;
}

int TouchingBlobs::separateGroup(const cv::Mat& image, const std::vector<const BrightRegion*>& group,
                                 std::vector<Blob>& blobs) const {
  int rejected = 0;
  const auto add = [&](const Blob& blob) {
    if (blob.spread < kMostSpread) {
      blobs.push_back(blob);
    } else {
      ++rejected;
    }
  };
  if (const auto fit = marker_ ? explain(image, group) : std::nullopt) {
    for (std::size_t k = 0; k < fit->discs.size(); ++k) {
      const Disc& disc = fit->discs[k];
      add({disc.centre, std::numbers::pi * disc.radius * disc.radius, 1.0,
           std::max(1.0, fit->centre_sd[k] / centre_sd_)});
    }
    return rejected;
  }
  for (const BrightRegion* region : group) {
    Blob blob = region->blob;
    if (marker_) blob.spread += region->asymmetry / centre_sd_;
    if (region->round) {
      add(blob);
    } else {
      ++rejected;
    }
  }
  return rejected;
}

int TouchingBlobs::separate(const cv::Mat& image, const std::vector<BrightRegion>& regions, double expected_radius,
                            std::vector<Blob>& blobs) {
  std::vector<const BrightRegion*> free, others;
  for (const BrightRegion& region : regions) (standsFree(region) ? free : others).push_back(&region);
  double area = std::numbers::pi * expected_radius * expected_radius;
  if (area == 0.0 && !free.empty()) area = medianArea(free);
  const auto large = std::stable_partition(
      free.begin(), free.end(), [area](const BrightRegion* region) { return region->blob.area <= kFreeArea * area; });
  others.insert(others.end(), large, free.end());
  free.erase(large, free.end());
  for (const BrightRegion* region : free) blobs.push_back(region->blob);
  ++age_;
  if (others.empty()) return 0;
  const double known_area = marker_ ? std::numbers::pi * marker_->radius * marker_->radius : 0.0;
  if (!marker_ || age_ > kOldest || (expected_radius > 0.0 && std::abs(known_area - area) > kOtherArea * area))
    learn(image, free, area);
  int rejected = 0;
  for (const auto& group : groupsOf(others)) rejected += separateGroup(image, group, blobs);
  return rejected;
}

}  // namespace simgap
