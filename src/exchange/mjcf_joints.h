/// \file
/// Joints of an arm as MJCF says them: stops, what holds a joint in one place and what ties it to another are soft
/// constraints in MuJoCo.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "remark_list.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// The least time step of MuJoCo for which stops and couplings are written.
inline constexpr double kMjcfTimeStep = 0.001;  ///< [s]

/// `<joint …/>` in a body. \param frame  of the joint's child in that body
std::string mjcfJoint(const ArmModel& model, const Joint& joint, const Eigen::Isometry3d& frame,
                      const std::string& indent);
/// What stands in <equality>: joints held in one place, coupled joints.
std::string mjcfCouplings(const ArmModel& model);
/// What of joints is not the same in MuJoCo, and how far off it is.
void nameSoftJoints(const ArmModel& model, RemarkList& remarks);

}  // namespace simgap
