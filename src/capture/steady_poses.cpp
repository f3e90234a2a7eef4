#include "simgap/capture/steady_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestSamples = 3;
constexpr double kDurationSlack = 1.0 - 1e-3;  // time stamps are rounded

using Samples = std::span<const JointSample>;

bool isSteady(Samples window, const std::vector<CaptureJoint>& joints, const SteadyOptions& options) {
  const auto n = static_cast<double>(window.size());
  const JointSample& middle = window[window.size() / 2];
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const JointKind& kind = kindOf(joints[j].type);
    double mean_time = 0.0;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const JointSample& s : window) {
      mean_time += s.time / n;
      mean += kind.counted * kind.difference(middle.joints[j], s.joints[j]) / n;
    }
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    double squares = 0.0;
    for (const JointSample& s : window) {
      const Eigen::Vector3d off = kind.counted * kind.difference(middle.joints[j], s.joints[j]) - mean;
      if (off.norm() > options.max_speed * options.duration) return false;
      slope += (s.time - mean_time) * off;
      squares += (s.time - mean_time) * (s.time - mean_time);
    }
    if (!(slope.norm() < options.max_speed * squares)) return false;
  }
  return true;
}

SteadyPose meanOf(Samples rest, const std::vector<CaptureJoint>& joints) {
  SteadyPose pose;
  pose.first_frame = rest.front().frame;
  pose.last_frame = rest.back().frame;
  pose.start = rest.front().time;
  pose.end = rest.back().time;
  pose.samples = rest.size();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    JointPosition mean;
    std::vector<Eigen::Quaterniond> rotations;
    for (const JointSample& s : rest) {
      rotations.push_back(s.joints[j].rotation);
      mean.angle += s.joints[j].angle / static_cast<double>(rest.size());
    }
    mean.rotation = meanRotation(rotations);
    double squares = 0.0;
    for (const JointSample& s : rest) squares += std::pow(jointError(joints[j].type, s.joints[j], mean), 2);
    pose.joints.push_back(mean);
    pose.spread.push_back(std::sqrt(squares / (static_cast<double>(rest.size()) - 1.0)));
  }
  return pose;
}

double correlation(const Speeds& joints, const Speeds& shafts, double lag) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (std::size_t i = 0; i < joints.times.size(); ++i) {
    const double x = joints.values[i];
    const double y = shafts.at(joints.times[i] - lag);
    n += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
  }
  const double variances = (n * sxx - sx * sx) * (n * syy - sy * sy);
  return variances > 0.0 ? (n * sxy - sx * sy) / std::sqrt(variances) : 0.0;
}

}  // namespace

RestFinder::RestFinder(std::vector<CaptureJoint> joints, const SteadyOptions& options)
    : joints_(std::move(joints)), options_(options) {}

std::span<const JointSample> RestFinder::kept(std::size_t first, std::size_t end) const {
  return std::span(samples_).subspan(first - begin_, end - first);
}

void RestFinder::closeRest() {
  if (rest_end_ > rest_) poses_.push_back(meanOf(kept(rest_, rest_end_), joints_));
}

/// What neither a window nor the rest can need any more, now and then.
void RestFinder::forget() {
  const std::size_t needed = window_ < rest_end_ ? rest_ : window_;
  if (2 * (needed - begin_) < samples_.size()) return;
  samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(needed - begin_));
  begin_ = needed;
}

void RestFinder::add(JointSample sample) {
  samples_.push_back(std::move(sample));
  const std::size_t end = begin_ + samples_.size();
  const double now = samples_.back().time;
  for (; window_ < end; ++window_) {
    const Samples window = kept(window_, end);
    if (now - window.front().time < kDurationSlack * options_.duration) break;
    // A window that grew over a gap in the recording says nothing of the gap.
    const bool gap = now - window.front().time > 2.0 * options_.duration;
    if (window.size() < kFewestSamples || gap || !isSteady(window, joints_, options_)) continue;
    if (window_ >= rest_end_) {
      closeRest();
      rest_ = window_;
    }
    rest_end_ = end;
  }
  if (window_ >= rest_end_) {  // no window that is still to come overlaps it
    closeRest();
    rest_ = rest_end_ = 0;
  }
  forget();
}

std::vector<SteadyPose> RestFinder::finish() {
  closeRest();
  rest_ = rest_end_ = 0;
  return take();
}

std::vector<SteadyPose> findSteadyPoses(Samples samples, const std::vector<CaptureJoint>& joints,
                                        const SteadyOptions& options) {
  RestFinder finder(joints, options);
  for (const JointSample& sample : samples) finder.add(sample);
  return finder.finish();
}

ShaftLog readShaftLog(const CsvTable& table) {
  ShaftLog log;
  log.file = table.name();
  log.times = table.quantity("time", "s");
  for (const std::string& column : table.columns()) {
    const std::string stem = splitUnit(column).stem;  // of shaft_rad, which names no muscle, it is shaft
    if (!stem.starts_with("shaft_")) continue;
    log.muscles.push_back(stem.substr(6));
    log.shafts.push_back(table.quantity("shaft_" + log.muscles.back(), "rad"));
  }
  if (log.muscles.empty()) {
    throw DataError(fmt::format("{}:1: found no column shaft_<muscle>_rad, expected at least one", log.file));
  }
  if (log.times.size() < 2) {
    throw DataError(fmt::format("{}: found {} rows, expected at least 2", log.file, log.times.size()));
  }
  for (std::size_t row = 1; row < log.times.size(); ++row) {
    if (!(log.times[row] > log.times[row - 1])) {
      table.fail(row,
                 fmt::format("time does not increase: found {} s behind {} s", log.times[row], log.times[row - 1]));
    }
  }
  return log;
}

bool joinShafts(SteadyPose& pose, const ShaftLog& log) {
  // Half a step of the log before its first and behind its last row counts as covered.
  const double step = (log.times.back() - log.times.front()) / static_cast<double>(log.times.size() - 1);
  if (pose.start < log.times.front() - 0.5 * step || pose.end > log.times.back() + 0.5 * step) return false;
  auto first = std::lower_bound(log.times.begin(), log.times.end(), pose.start) - log.times.begin();
  auto end = std::upper_bound(log.times.begin(), log.times.end(), pose.end) - log.times.begin();
  if (first == end) {  // a slow log without a row inside the rest: the row before it
    first = std::max<std::ptrdiff_t>(0, first - 1);
    end = first + 1;
  }
  for (const std::vector<double>& shaft : log.shafts) {
    double sum = 0.0;
    for (auto row = first; row < end; ++row) sum += shaft[row];
    pose.shafts.push_back(sum / static_cast<double>(end - first));
  }
  return true;
}

double Speeds::at(double time) const {
  if (time <= times.front() || time >= times.back()) return 0.0;
  const auto next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  const auto i = static_cast<std::size_t>(next);
  const double part = (time - times[i - 1]) / (times[i] - times[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

void JointSpeeds::add(const JointSample& sample) {
  if (last_) {
    const double step = sample.time - last_->time;
    double squares = 0.0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const JointKind& kind = kindOf(joints_[j].type);
      squares += (kind.counted * kind.difference(last_->joints[j], sample.joints[j])).squaredNorm();
    }
    speeds_.times.push_back(0.5 * (sample.time + last_->time));
    speeds_.values.push_back(std::sqrt(squares) / step);
  } else {
    first_time_ = sample.time;
  }
  last_ = sample;
}

double JointSpeeds::step() const { return (last_->time - first_time_) / static_cast<double>(speeds_.times.size()); }

Lag estimateLag(const JointSpeeds& joints, const ShaftLog& log, double range) {
  Lag best;
  if (joints.speeds().times.size() + 1 < kFewestSamples) return best;
  Speeds shafts;
  for (std::size_t i = 1; i < log.times.size(); ++i) {
    double squares = 0.0;
    for (const auto& shaft : log.shafts) squares += std::pow(shaft[i] - shaft[i - 1], 2);
    shafts.times.push_back(0.5 * (log.times[i] + log.times[i - 1]));
    shafts.values.push_back(std::sqrt(squares) / (log.times[i] - log.times[i - 1]));
  }
  const double step = 0.25 * joints.step();
  const int steps = static_cast<int>(range / step);
  best.correlation = correlation(joints.speeds(), shafts, 0.0);
  for (int i = 1; i <= 2 * steps; ++i) {  // outwards from zero: of equal lags the smallest
    const double lag = (i % 2 == 1 ? 1 : -1) * ((i + 1) / 2) * step;
    const double value = correlation(joints.speeds(), shafts, lag);
    if (value > best.correlation + 1e-9) best = {lag, value};
  }
  return best;
}

CsvWriter posesCsv(const std::vector<CaptureJoint>& joints, const std::vector<std::string>& muscles) {
  std::vector<std::string> header{"pose", "repeat", "time_s"};
  for (const std::string& muscle : muscles) header.push_back("shaft_" + muscle + "_rad");
  for (const CaptureJoint& joint : joints) {
    for (std::string& column : positionColumns(joint.type, joint.name)) header.push_back(std::move(column));
  }
  for (const CaptureJoint& joint : joints)
    header.push_back(fmt::format("{}_spread_{}", joint.name, kindOf(joint.type).unit));
  header.emplace_back("samples");
  return CsvWriter(header);
}

void addPose(CsvWriter& csv, std::size_t number, const SteadyPose& pose, const std::vector<CaptureJoint>& joints) {
  csv.add(fmt::format("p{:03}", number)).add(0.0).add(0.5 * (pose.start + pose.end));
  for (const double shaft : pose.shafts) csv.add(shaft);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (const double cell : kindOf(joints[j].type).cells(pose.joints[j])) csv.add(cell);
  }
  for (const double spread : pose.spread) csv.add(spread);
  csv.add(static_cast<double>(pose.samples)).endRow();
}

}  // namespace simgap
