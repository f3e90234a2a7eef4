/// \file
/// A whole recording: pairs in, joint angles, poses, tables and figures out.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "simgap/capture/capture_files.h"
#include "simgap/capture/capture_statistics.h"
#include "simgap/capture/image_pairs.h"
#include "simgap/capture/live_cameras.h"
#include "simgap/capture/rest_spool.h"
#include "simgap/capture/steady_poses.h"
#include "simgap/core/run_directory.h"

namespace simgap {

struct CaptureRunOptions {
  CaptureOptions capture;
  SteadyOptions steady;
  std::set<std::size_t> overlays;  ///< numbers of pairs to draw
  bool partial = false;            ///< go on when a target is never seen
  double max_shaft_lag = 0.25;     ///< [s] of the joints behind the shafts
};

/// Many latencies in little memory: how many there are of each size, in steps of 1 %.
class LatencyCounts {
 public:
  void add(double seconds);
  /// So that a share of `part` lies below it, within 1 %; part 1: the largest [s]. There has to be one.
  double quantile(double part) const;
  std::size_t count() const { return count_; }

 private:
  static constexpr double kStep = 0.01;      ///< of the logarithm
  static constexpr double kSmallest = 1e-6;  ///< [s]
  std::vector<std::size_t> counts_;
  std::size_t count_ = 0;
  double largest_ = 0.0;
};

/// How a run with cameras that ran went.
struct LiveFigures {
  LiveCounts counts;
  std::size_t pairs = 0, poses = 0;  ///< poses: pairs with all joints
  double seconds = 0.0;              ///< from the first image on [s]
  LatencyCounts latency;             ///< of pairs, from the image to its angles
  double started_unix = 0.0;         ///< [s] since 1970: what time_s counts from
};

struct CaptureResult {
  TargetSet targets;
  Rig rig;
  FrameTimes times;
  std::size_t samples = 0;  ///< pairs with all joints
  RestSpool poses;
  std::vector<std::string> muscles;
  std::size_t poses_outside_log = 0;
  std::optional<Lag> lag;
  std::vector<std::string> skipped;
  std::vector<std::size_t> missing_overlays;
  std::vector<GeometryFinding> doubts;
  std::optional<LiveFigures> live;
};

/// Tables and rests go to files as the pairs come: memory does not grow with their number, but for the longest rest
/// and, with a shaft log, two numbers of a pair (16 bytes).
class CaptureRun {
 public:
  CaptureRun(const StereoCameras& cameras, const TargetSet& targets, const Rig& rig, const FrameTimes& times,
             const CaptureRunOptions& options, std::optional<ShaftLog> shafts = {});

  /// One pair; call in order. \returns whether all joints were found. \throws DataError: all that StereoCapture
  /// refuses.
  bool add(const cv::Mat& left, const cv::Mat& right, std::size_t number, double time);
  /// The same of a recording. \throws DataError: more pairs than time stamps, and all that StereoCapture refuses.
  void add(const ImagePairs& pairs);
  /// \throws DataError: no target in any frame, a target that was never seen (unless `partial`), fewer pairs than time
  ///         stamps, joints that move more than max_shaft_lag after the shafts.
  CaptureResult finish(const std::vector<std::string>& skipped);
  /// frames.csv, joints.csv, poses.csv, markers.trc and the overlays.
  void write(const RunDirectory& directory, const CaptureResult& result) const;

  const CaptureStatistics& statistics() const { return statistics_; }

 private:
  void refuseUnseen() const;
  void keep(std::vector<SteadyPose> rests);

  StereoCameras cameras_;
  TargetSet targets_;
  Rig rig_;
  FrameTimes times_;
  CaptureRunOptions options_;
  StereoCapture capture_;
  CaptureStatistics statistics_;
  std::optional<ShaftLog> shafts_;
  TextSpool frames_csv_, trc_, joints_csv_;
  std::size_t samples_ = 0;
  RestFinder rests_;
  RestSpool poses_;
  std::size_t poses_outside_log_ = 0;
  JointSpeeds speeds_;                                         ///< with a shaft log
  std::vector<std::pair<std::size_t, std::string>> overlays_;  ///< pair, PNG
};

}  // namespace simgap
