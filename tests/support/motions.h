/// \file
/// A one-joint arm that moves, as it is believed to be and as it really is, with motions that the independent simulator
/// recorded of it.
#pragma once

#include "reality/arm_motion.h"
#include "simgap/simulate/motion_player.h"
#include "support/files.h"

namespace simgap::test {

/// A forearm on a hinge between two muscles.
reality::MovingArm movingForearm();
/// The same with other lines, friction and damping than it is believed to have.
reality::MovingArm trueForearm();

/// Steps of co-contraction and a sine, set by `draw`.
reality::Setpoints forearmSetpoints(int draw);

/// `count` motions of an arm as the rig logs them, read for its model; number i has the commands of `commands(i)`.
MotionSet recordMotions(const reality::MovingArm& truth, const ArmModel& model,
                        const std::function<reality::Setpoints(std::uint64_t)>& commands, std::uint64_t first,
                        std::size_t count, const reality::MotionRigOptions& options);

/// A motion set of `count` motions of the true forearm in `folder`/NAME.yaml, drawn from `first` on.
void putMotions(const TemporaryFolder& folder, const std::string& name, int first, int count,
                const reality::MotionRigOptions& options = {});

/// The same moved by voltages: pulses that wind up and pay out.
void putVoltageMotions(const TemporaryFolder& folder, const std::string& name, int first, int count);
/// A pose set of the true forearm's rests, joint friction left out.
void putRests(const TemporaryFolder& folder, const std::string& name);

/// The parameters in which the two forearms differ.
std::string forearmConfig();

}  // namespace simgap::test
