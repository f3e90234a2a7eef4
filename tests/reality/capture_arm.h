/// \file
/// An arm with marker targets in front of two cameras: the truth behind rendered images.
#pragma once

#include <filesystem>
#include <vector>

#include "reality/stereo_scene.h"

namespace simgap::reality {

/// Position of the arm: humerus in torso (at the shoulder, the torso's origin), forearm about the humerus' x axis.
struct ArmPose {
  Eigen::Quaterniond shoulder = Eigen::Quaterniond::Identity();
  double elbow = 0.0;  ///< [rad]
};

/// Markers fixed to a body, in its frame [m].
struct MarkerTarget {
  std::string name;
  std::vector<Eigen::Vector3d> markers;
};

/// Targets on torso, humerus and forearm, 10-15 cm wide: 4, 5 and 4 markers.
std::vector<MarkerTarget> standardTargets();
/// Others of 4, 5 and 4 markers about where the standard ones are; a pure function of the seed. Distances within a
/// target differ by at least 4 mm.
std::vector<MarkerTarget> drawnTargets(std::uint64_t seed);
std::string targetsYaml(const std::vector<MarkerTarget>& targets, double radius = 0.006);

/// A pose within the arm's reach and the cameras' view; a pure function of the seed.
ArmPose randomPose(std::uint64_t seed);
/// The same with an elbow from straight to 1.6 rad: markers of the forearm then come to touch in the images.
ArmPose widePose(std::uint64_t seed);
/// Between two poses: `t` = 0 gives a, 1 gives b.
ArmPose between(const ArmPose& a, const ArmPose& b, double t);

/// What disturbs the view of one frame.
struct Disturbance {
  double occluded = 0.0;  ///< probability that a marker is hidden from both cameras
  int ghosts = 0;         ///< reflections per image
  bool glare = false;     ///< of an LED: large and saturated
  double blocker = 0.0;   ///< [m] radius of a dark ball 5 cm in front of a random marker, 0: none
};

/// Positions of the markers in the left camera, shape (targets, markers) [m].
std::vector<std::vector<Eigen::Vector3d>> markersInLeft(const std::vector<MarkerTarget>& targets, const ArmPose& pose);

struct RenderedPair {
  Image left, right;
  std::vector<std::vector<Eigen::Vector3d>> markers;  ///< in the left camera [m]
  std::vector<std::vector<bool>> visible;             ///< drawn at all
};

/// The whole set-up. `radius` of the markers [m].
class CaptureStage {
 public:
  CaptureStage(const StereoLenses& lenses, std::vector<MarkerTarget> targets, const Light& light = {},
               double radius = 0.006);
  /// \param poses  the arm over the exposure; one: it stands still.
  RenderedPair render(const std::vector<ArmPose>& poses, const Disturbance& disturbance, std::uint64_t seed) const;
  const StereoLenses& lenses() const { return lenses_; }
  const std::vector<MarkerTarget>& targets() const { return targets_; }
  /// Writes stereo.yaml, targets.yaml and rig.yaml (with a scale bar between two markers of the torso).
  void writeRig(const std::filesystem::path& folder) const;

 private:
  StereoLenses lenses_;
  std::vector<MarkerTarget> targets_;
  double radius_;
  Camera left_, right_;
};

}  // namespace simgap::reality
