/// \file
/// Rigid targets of spherical markers, and the rig that sees them: `simgap/targets/1`, `simgap/rig/1`.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/rotation.h"
#include "simgap/core/yaml.h"

namespace simgap {

/// Markers fixed to one body.
struct MarkerTarget {
  std::string name;
  std::string body;
  std::vector<Eigen::Vector3d> markers;  ///< centres in the body's frame [m], 3 to 16
};

struct TargetSet {
  double marker_radius = 0.0;  ///< [m]
  std::vector<MarkerTarget> targets;
  int indexOf(const std::string& target) const;  ///< -1 when there is none
};

/// \throws ConfigError: fewer than 3 markers, markers on one line or one upon the other, a name twice, and all that
///         YamlNode refuses.
TargetSet readTargets(const YamlNode& root);
std::string writeTargets(const TargetSet& targets, const std::vector<std::string>& comments = {});

/// Two markers whose distance was measured by other means.
struct ScaleBar {
  std::array<int, 2> target{};  ///< indices into TargetSet::targets
  std::array<int, 2> marker{};
  double length = 0.0;  ///< [m]
};

/// A joint between two targets.
struct CaptureJoint {
  std::string name;
  JointType type{};
  int parent = 0;                                   ///< target index
  int child = 0;                                    ///< target index
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< of one that has it: in the parent's frame, unit length
  std::optional<Eigen::Vector3d> along = {};        ///< unit length: from the parent's origin to this joint, if known
  double zero = 0.0;  ///< of a slide: how far along its axis the child's origin stands from the parent's at 0 [m]
};

struct Rig {
  std::string stereo_file;  ///< as the rig names it, relative to the rig's folder
  std::string targets_file;
  std::optional<ScaleBar> scale_bar;
  std::vector<CaptureJoint> joints;
};

/// A rig whose targets are known. Without `joints:` the joints are those of the paper's arm: shoulder (spherical, torso
/// to humerus) and elbow (revolute about x, humerus to forearm,
/// which hangs along -z), by the bodies of the targets.
/// \throws ConfigError: unknown target, marker or body, an axis without length.
Rig readRig(const YamlNode& root, const TargetSet& targets);
/// The files a rig names: {stereo, targets}; read before readRig. \throws ConfigError
std::array<std::string, 2> rigFiles(const YamlNode& root);
/// The rig as a file; reads back the same.
std::string writeRig(const Rig& rig, const TargetSet& targets);

}  // namespace simgap
