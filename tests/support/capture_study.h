/// \file
/// Rendered stereo images (reality/capture_arm.h) through the capture, and how far it is from the truth.
#pragma once

#include <string>
#include <vector>

#include "reality/capture_arm.h"
#include "simgap/capture/stereo_capture.h"

namespace simgap::test {

StereoCameras camerasOf(const reality::StereoLenses& lenses);
TargetSet targetsOf(const std::vector<reality::MarkerTarget>& targets, double radius = 0.006);
/// The same memory as an OpenCV image.
cv::Mat matOf(const reality::Image& image);

struct StudyOptions {
  int scale = 1;  ///< 1: 640x480, 2: 1280x960
  int pairs = 100;
  reality::Disturbance disturbance;
  bool sequence = false;      ///< a moving arm instead of independent poses: uses the tracking
  int exposures = 1;          ///< more: motion blur (with `sequence`)
  bool wide = false;          ///< the elbow from straight to 1.6 rad (reality::widePose)
  int rest = 0;               ///< frames for which the arm rests before it jumps to the next pose; 0: see `sequence`
  std::uint64_t targets = 0;  ///< 0: reality::standardTargets; else the seed of reality::drawnTargets
  double radius = 0.006;      ///< of the markers [m]
  std::uint64_t seed = 1;
};

struct StudyResult {
  int pairs = 0;
  int visible_targets = 0;                     ///< at least 3 markers drawn
  int found_targets = 0;                       ///< of these
  int whole_pairs = 0;                         ///< all markers drawn inside both images, touching or not
  int captured_pairs = 0;                      ///< of these: all targets found
  int wrong_identities = 0;                    ///< markers whose blob belongs to something else
  double fit_rms = 0.0;                        ///< [m] root mean square over targets
  double shoulder_deg = 0.0, elbow_deg = 0.0;  ///< root mean square errors of the joints
  double relative_deg = 0.0;                   ///< of all relative target rotations
  double position_rms = 0.0;                   ///< [m] of the targets' first markers, per axis
  double sd_ratio = 0.0;    ///< observed spread / reported standard deviation of relative rotations and positions
  double process_ms = 0.0;  ///< median processor time of a pair
  double mean_ms = 0.0;     ///< mean processor time of a pair
};

StudyResult runStudy(const StudyOptions& options);
std::string describe(const std::string& name, const StudyResult& result);

}  // namespace simgap::test
