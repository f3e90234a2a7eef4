#include "simgap/capture/capture_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr double kLagRange = 0.5;  // [s] searched on both sides

/// Distances of the markers of each target: nominal, measured, and the spread that the noise of the blobs predicts.
std::string distancesCsv(const TargetSet& targets, const CaptureStatistics& s) {
  CsvWriter csv({"target", "markers", "nominal_mm", "mean_mm", "sd_mm", "predicted_sd_mm"});
  for (const DistanceStatistics& d : s.distances()) {
    csv.add(targets.targets[d.target].name);
    csv.add(fmt::format("{}-{}", d.markers[0], d.markers[1])).add(1e3 * d.nominal);
    if (d.measured.count() > 1) {
      csv.add(1e3 * d.measured.mean()).add(1e3 * d.measured.sd()).add(1e3 * std::sqrt(d.variance.mean()));
    } else {
      csv.add("").add("").add("");
    }
    csv.endRow();
  }
  return csv.text();
}

void writePoses(const std::filesystem::path& file, const CaptureResult& result) {
  constexpr std::size_t kAtOnce = 100;
  const CsvWriter head = posesCsv(result.rig.joints, result.muscles);
  std::string piece;
  std::size_t next = 0, headed = 0;  // headed: bytes of the head that stand in the file already
  writeFileAtomically(file, [&]() -> std::string_view {
    CsvWriter csv = head;
    for (const std::size_t end = std::min(next + kAtOnce, result.poses.size()); next < end; ++next) {
      addPose(csv, next, result.poses.at(next), result.rig.joints);
    }
    piece = csv.text().substr(std::exchange(headed, head.text().size()));
    return piece;
  });
}

/// How many distances are off by how much.
std::string histogramCsv(const CaptureStatistics& s) {
  CsvWriter csv({"error_mm", "count"});
  for (int b = 0; b < DistanceHistogram::kBins; ++b) {
    csv.add(fmt::format("{:.2f}", 1e3 * DistanceHistogram::kStep * (b - DistanceHistogram::kBins / 2 + 0.5)));
    csv.add(static_cast<double>(s.histogram().counts[b])).endRow();
  }
  return csv.text();
}

}  // namespace

void LatencyCounts::add(double seconds) {
  const double size = std::log(std::max(seconds, kSmallest) / kSmallest) / kStep;
  const auto bin = static_cast<std::size_t>(std::min(size, 1e4));
  if (bin >= counts_.size()) counts_.resize(bin + 1, 0);
  ++counts_[bin];
  ++count_;
  largest_ = std::max(largest_, seconds);
}

double LatencyCounts::quantile(double part) const {
  const auto rank = static_cast<std::size_t>(part * static_cast<double>(count_ - 1));
  if (rank + 1 == count_) return largest_;
  std::size_t below = 0, bin = 0;
  while (below + counts_[bin] <= rank) below += counts_[bin++];
  return std::min(largest_, kSmallest * std::exp(kStep * (static_cast<double>(bin) + 0.5)));
}

CaptureRun::CaptureRun(const StereoCameras& cameras, const TargetSet& targets, const Rig& rig, const FrameTimes& times,
                       const CaptureRunOptions& options, std::optional<ShaftLog> shafts)
    : cameras_(cameras),
      targets_(targets),
      rig_(rig),
      times_(times),
      options_(options),
      capture_(cameras, targets, options.capture),
      statistics_(cameras, targets, rig),
      shafts_(std::move(shafts)),
      rests_(rig.joints, options.steady),
      speeds_(rig.joints) {}

void CaptureRun::add(const ImagePairs& pairs) {
  const std::size_t number = pairs.frame();
  if (!times_.times.empty() && number >= times_.times.size()) {
    throw DataError(fmt::format("found more image pairs than the {} time stamps", times_.times.size()));
  }
  try {
    add(pairs.left(), pairs.right(), number, times_.at(number));
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}, {}: {}", pairs.leftName(), pairs.rightName(), error.what()));
  }
}

bool CaptureRun::add(const cv::Mat& left, const cv::Mat& right, std::size_t number, double time) {
  const FramePair& frame = capture_.process(left, right);
  statistics_.add(frame, capture_.centroidSd());
  frames_csv_.add(framesCsvRows(targets_, frame, number, time));
  trc_.add(trcRow(targets_, frame, number, time));
  auto sample = jointAngles(rig_, frame.targets, number, time);
  const bool whole = sample.has_value();
  if (whole) {
    ++samples_;
    joints_csv_.add(jointsCsvRow(rig_.joints, *sample));
    if (shafts_) speeds_.add(*sample);
    rests_.add(std::move(*sample));
    keep(rests_.take());
  }
  if (options_.overlays.contains(number)) {
    overlays_.emplace_back(number, encodePng(drawOverlay(cameras_, targets_, frame, left, right)));
  }
  return whole;
}

void CaptureRun::keep(std::vector<SteadyPose> rests) {
  for (SteadyPose& rest : rests) {
    if (shafts_ && !joinShafts(rest, *shafts_)) {
      ++poses_outside_log_;
    } else {
      poses_.add(rest);
    }
  }
}

void CaptureRun::refuseUnseen() const {
  std::string unseen;
  std::size_t seen = 0;
  for (std::size_t t = 0; t < targets_.targets.size(); ++t) {
    if (statistics_.found(t) > 0) {
      ++seen;
    } else {
      unseen += (unseen.empty() ? "" : ", ") + targets_.targets[t].name;
    }
  }
  if (seen == 0) {
    throw DataError(
        fmt::format("found no target in {} pairs ({:.1f} bright blobs per left image, {:.1f} per right "
                    "one): wrong targets, wrong stereo calibration, or no markers in view",
                    statistics_.frames(), statistics_.blobs(0).mean(), statistics_.blobs(1).mean()));
  }
  if (!unseen.empty() && !options_.partial) {
    throw DataError(fmt::format("never found the target {} in {} pairs (--partial goes on without it)", unseen,
                                statistics_.frames()));
  }
}

CaptureResult CaptureRun::finish(const std::vector<std::string>& skipped) {
  const std::size_t read = statistics_.frames() + skipped.size();
  if (!times_.times.empty() && read < times_.times.size()) {
    throw DataError(fmt::format("found {} time stamps for {} image pairs", times_.times.size(), read));
  }
  refuseUnseen();
  CaptureResult result;
  result.targets = targets_;
  result.rig = rig_;
  result.times = times_;
  result.samples = samples_;
  result.skipped = skipped;
  result.doubts = statistics_.doubts();
  for (const std::size_t number : options_.overlays) {
    if (number >= read) result.missing_overlays.push_back(number);
  }
  keep(rests_.finish());
  result.poses = std::move(poses_);
  result.poses_outside_log = poses_outside_log_;
  if (shafts_) {
    result.muscles = shafts_->muscles;
    result.lag = estimateLag(speeds_, *shafts_, kLagRange);
    if (result.lag->correlation > Lag::kClearCorrelation && std::abs(result.lag->seconds) > options_.max_shaft_lag) {
      throw DataError(
          fmt::format("{}: the joints move {:.0f} ms after the shafts, expected at most {:.0f} ms: are the "
                      "clocks synchronised?",
                      shafts_->file, 1e3 * result.lag->seconds, 1e3 * options_.max_shaft_lag));
    }
  }
  return result;
}

void CaptureRun::write(const RunDirectory& directory, const CaptureResult& result) const {
  frames_csv_.writeTo(directory.file("frames.csv"), framesCsvHeader());
  trc_.writeTo(directory.file("markers.trc"), trcHeader(targets_, times_.rate, statistics_.frames(), "markers.trc"));
  joints_csv_.writeTo(directory.file("joints.csv"), jointsCsvHeader(rig_.joints));
  directory.write("distances.csv", distancesCsv(targets_, statistics_));
  directory.write("histogram.csv", histogramCsv(statistics_));
  writePoses(directory.file("poses.csv"), result);
  for (const auto& [number, png] : overlays_) directory.write(fmt::format("overlay_{:05}.png", number), png);
}

}  // namespace simgap
