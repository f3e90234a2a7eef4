/// \file
/// Pieces of XML that writers share.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>

#include "simgap/model/arm/body.h"

namespace simgap {

/// A text inside of an attribute.
std::string xmlText(std::string_view text);
/// Three numbers, each the shortest text that reads back as the same bits.
std::string xmlNumbers(const Eigen::Vector3d& v);
/// ` pos="…" quat="…"` of MJCF; no quat of an identity.
std::string mjcfFrame(const Eigen::Isometry3d& frame);
/// ` quat="…"` that turns z to an axis; empty for z.
std::string alongZ(const Eigen::Vector3d& axis);
/// A part to look at; empty for a stated inertia.
std::string mjcfGeom(const Part& part, const std::string& indent);

}  // namespace simgap
