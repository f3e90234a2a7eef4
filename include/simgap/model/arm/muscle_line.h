/// \file
/// The line of a muscle through space.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {

/// The points a muscle's line runs through [m]: its attachments and, where an extension wraps it round a joint, the
/// arc. \param bodies  in the world, shape (bodies)
std::vector<Eigen::Vector3d> muscleLine(const ArmModel& model, std::size_t muscle,
                                        const std::vector<BodyInWorld>& bodies);

}  // namespace simgap
