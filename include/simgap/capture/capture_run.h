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

/// What one pair told, for plots.
struct FrameDigest {
  double time;             ///< [s]
  float ghosts;            ///< blobs
  std::vector<float> rms;  ///< shape (targets) [mm]; NaN when not found
};

/// How a run with cameras that ran went.
struct LiveFigures {
  LiveCounts counts;
  std::size_t pairs = 0, poses = 0;  ///< poses: pairs with all joints
  double seconds = 0.0;              ///< from the first image on [s]
  std::vector<double> latency;       ///< per pair, from its image to its angles [s]
  double started_unix = 0.0;         ///< [s] since 1970: what time_s counts from
};

struct CaptureResult {
  TargetSet targets;
  Rig rig;
  FrameTimes times;
  std::vector<JointSample> samples;
  std::vector<SteadyPose> poses;
  std::vector<std::string> muscles;
  std::size_t poses_outside_log = 0;
  std::optional<Lag> lag;
  std::vector<FrameDigest> digests;
  std::vector<std::string> skipped;
  std::vector<std::size_t> missing_overlays;
  std::vector<GeometryFinding> doubts;
  std::optional<LiveFigures> live;
};

class CaptureRun {
 public:
  CaptureRun(const StereoCameras& cameras, const TargetSet& targets, const Rig& rig, const FrameTimes& times,
             const CaptureRunOptions& options);

  /// One pair; call in order. \returns whether all joints were found. \throws DataError: all that StereoCapture
  /// refuses.
  bool add(const cv::Mat& left, const cv::Mat& right, std::size_t number, double time);
  /// The same of a recording. \throws DataError: more pairs than time stamps, and all that StereoCapture refuses.
  void add(const ImagePairs& pairs);
  /// \throws DataError: no target in any frame, a target that was never seen (unless `partial`), fewer pairs than time
  ///         stamps, joints that move more than max_shaft_lag after the shafts.
  CaptureResult finish(const std::vector<std::string>& skipped, const std::optional<ShaftLog>& shafts);
  /// frames.csv, joints.csv, poses.csv, markers.trc and the overlays.
  void write(const RunDirectory& directory, const CaptureResult& result) const;

  const CaptureStatistics& statistics() const { return statistics_; }

 private:
  void refuseUnseen() const;

  StereoCameras cameras_;
  TargetSet targets_;
  Rig rig_;
  FrameTimes times_;
  CaptureRunOptions options_;
  StereoCapture capture_;
  CaptureStatistics statistics_;
  TextSpool frames_csv_, trc_;
  std::vector<JointSample> samples_;
  std::vector<FrameDigest> digests_;
  std::vector<std::pair<std::size_t, std::string>> overlays_;  ///< pair, PNG
};

}  // namespace simgap
