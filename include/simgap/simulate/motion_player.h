/// \file
/// A recorded motion played to a simulated arm: its commands in, what was measured meanwhile out.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/measure/motion_set.h"
#include "simgap/simulate/bullet_arm.h"

namespace simgap {

struct MotionOptions {
  BulletArmOptions arm{.step = 0.001};
  double settle = 1.5;  ///< [s] under the first commands before a motion begins; 0 where its start was measured
};

/// What the arm did, at the times at which the real one was measured.
struct PlayedMotion {
  bool valid = false;
  double failed_at = 0.0;             ///< [s] on the motion's clock, where it blew up
  int worst = -1;                     ///< the joint that was fastest then
  std::vector<JointPosition> joints;  ///< shape (frames, joints), as markers show them
  std::vector<double> shafts;         ///< shape (rows, muscles) [rad]
  std::vector<double> currents;       ///< shape (rows, muscles) [A]
};

/// Resets the arm to rest under the motion's first commands (the equilibrium at those shafts, then `settle`), or to its
/// measured start, and plays its commands.
/// \param rest  where the arm comes to rest under the first commands: restPose(); unused with a measured start
/// \param capture_delay  the frame at time t on the capture's clock was taken at t + capture_delay [s]
/// \param[out] played  memory is taken on first use only
void playMotion(BulletArm& arm, const RecordedMotion& motion, const MotionOptions& options,
                std::span<const JointPosition> rest, double capture_delay, PlayedMotion& played);

/// The equilibrium under a motion's first commands, where settling begins; the first measured pose, where there is
/// none or the commands are no shaft angles.
std::vector<JointPosition> restPose(const ArmModel& model, const RecordedMotion& motion);

/// "the arm blew up after 1.20 s: shoulder; …": why a motion could not be played.
std::string describeFailure(const PlayedMotion& played, const PoseLayout& layout, const MotionOptions& options);

}  // namespace simgap
