/// \file
/// A robot with one thing that its model will not know, hidden at a joint or a body that is drawn, of a size that
/// shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reality/robot_rig.h"

namespace simgap::reality {

struct RobotFlaw {
  std::string cause;   ///< as `simgap diagnose` calls it
  std::string target;  ///< "j3", "link2", "j2 by j3" or nothing
  Robot robot;         ///< with it

  std::string label() const { return target.empty() ? cause : cause + ":" + target; }
};

/// Causes that the study hides in turn; "position-delay" can be hidden besides.
const std::vector<std::string>& robotFlawNames();

/// Sizes of what changes torques are such that the change is 0.7 to 4 times the noise of the joint where it is largest
/// in that; offsets, delays and gains are drawn as rigs have them. \param motion  draws the log that it is scaled on
RobotFlaw hideFlaw(const Robot& robot, const std::string& cause, const RobotRigOptions& options, std::uint64_t motion,
                   std::uint64_t draw);

}  // namespace simgap::reality
