/// \file
/// Pieces of an arm file. `simgap/arm/2` knows all of them; `simgap/arm/1` only what stands in docs/formats.md for it.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap::arm_yaml {

/// Where a body of the file is in the model: itself, or a place on the body it is welded to.
struct Place {
  int body = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< in that body
  int first_surface = 0;                                   ///< of its own among that body's
  std::vector<std::string> surfaces;                       ///< names in the file
};
using Places = std::map<std::string, Place>;

std::string readName(const YamlNode& node, std::set<std::string>& taken);
Eigen::Vector3d readAxis(const YamlNode& node);
/// `<stem>_orientation: [w, x, y, z]` or `<stem>_rpy_rad: [roll, pitch, yaw]` about fixed axes; identity without.
Eigen::Quaterniond readOrientation(const YamlNode& node, const std::string& stem);
/// A joint's quantities have other units where it slides: jointUnit(j, "Nm") is "N".
std::string_view jointUnit(const Joint& joint, std::string_view unit);

Body readBodyEntry(const YamlNode& node, std::set<std::string>& names, bool second_version, const MeshReader& mesh);
/// Bodies and joints as a forest rooted in fixed bodies; bodies of fixed joints are welded to their parents.
Places readBodiesAndJoints(const YamlNode& root, ArmModel& model, bool second_version, const MeshReader& mesh);
TendonPath readPath(const YamlNode& node, const ArmModel& model, const Places& places, bool second_version);
PassiveTendon readTendon(const YamlNode& node, const ArmModel& model, const Places& places,
                         std::set<std::string>& names);

}  // namespace simgap::arm_yaml
