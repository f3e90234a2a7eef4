/// \file
/// An arm played with commands over time.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "simgap/measure/motion_commands.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/muscle_controller.h"

namespace simgap {

struct JointTargets;
class JointPositionController;

struct RolloutOptions {
  double step = 0.001;  ///< [s] the controllers' period is a whole number of steps
  ControllerOptions controllers;
  /// Of drives and controllers within a step: 2 lets bodies, which are slow beside them, go on in steps twice as long
  /// as the controllers' period.
  int drive_steps = 1;
  std::shared_ptr<const JointTargets> targets = nullptr;  ///< given: they make the forces of all muscles in run()
  bool operator==(const RolloutOptions&) const = default;
  /// \throws ConfigError
  void validate() const;
};

/// How a motion begins.
struct MotionStart {
  std::vector<JointPosition> joints;                   ///< shape (joints); empty: startPosition()
  std::vector<Eigen::Vector3d> joint_velocities = {};  ///< shape (joints), as BulletArm::setJointVelocity; empty: rest
  std::vector<double> shafts = {};                     ///< shape (muscles) or model.commands() [rad]; empty: 0
  double time = 0.0;                                   ///< of the commands' clock [s]
  double settle = 0.0;  ///< before `time` the arm is held by the commands of `time` for so long [s]
};

/// States of an arm at given times. Columns: times.
struct MotionTrack {
  std::vector<double> times;                      ///< shape (rows) [s], rising
  std::vector<JointPosition> joints;              ///< shape (rows, joints), as markers show them
  std::vector<Eigen::Vector3d> joint_velocities;  ///< shape (rows, joints), as BulletArm::jointVelocity [rad/s]
  Eigen::MatrixXd shafts;                         ///< shape (muscles, rows) [rad]
  Eigen::MatrixXd shaft_velocities;               ///< shape (muscles, rows) [rad/s]
  Eigen::MatrixXd cord_lengths;                   ///< shape (muscles, rows) [m]
  Eigen::MatrixXd forces;                         ///< shape (muscles, rows) [N], of the middle of a step
  Eigen::MatrixXd currents;                       ///< shape (muscles, rows) [A]
  Eigen::MatrixXd voltages;                       ///< shape (muscles, rows) [V], as set by the last tick
  Eigen::MatrixXd line_commands;                  ///< shape (lines, rows), what acts: BulletArm::lineCommand
  Eigen::MatrixXd line_forces;                    ///< shape (lines, rows) [N], at joints [N m]
  std::size_t joint_count = 0;

  void resize(std::size_t rows, std::size_t joints, std::size_t muscles, std::size_t lines);
  std::span<const JointPosition> jointsAt(std::size_t row) const {
    return std::span(joints).subspan(row * joint_count, joint_count);
  }
};

/// How a motion ended.
struct MotionOutcome {
  bool finished = true;  ///< false: the simulation blew up
  double time = 0.0;     ///< [s] when it ended, or blew up
  int joint = -1;        ///< that blew up; -1: a muscle did
  int muscle = -1;
  std::size_t rows = 0;  ///< of the track that are filled
};

/// Plays motions. A worker keeps one for many motions and models; a motion depends on model, commands and start alone,
/// to the last bit.
class Rollout {
 public:
  /// \throws ConfigError as RolloutOptions::validate
  Rollout(const ArmModel& model, const RolloutOptions& options);
  ~Rollout();
  Rollout(Rollout&&) noexcept;
  Rollout& operator=(Rollout&&) noexcept;

  /// Another model of as many joints and muscles.
  void setModel(const ArmModel& model);

  /// Plays until the last of `times`. Nothing is allocated when the track has its size and the kinds of commands are
  /// those of the call before. Lines that take a command have followed the first one when it begins. \param times
  /// rising, none before start.time [s]
  MotionOutcome run(const MotionCommands& commands, const MotionStart& start, std::span<const double> times,
                    MotionTrack& track);

  /// \name The same step by step, for those who make their commands as they go
  ///@{
  void begin(std::span<const CommandKind> kinds, const MotionStart& start);
  /// One physics step under commands of shape (muscles + lines); they are looked at when the controllers tick.
  /// \returns false once the simulation has blown up
  bool step(std::span<const double> commands);
  double time() const;  ///< [s]
  BulletArm& arm() { return arm_; }
  const BulletArm& arm() const { return arm_; }
  ///@}

 private:
  struct Sample;
  void prepare(std::span<const CommandKind> kinds);
  void commandAt(double time, const MotionCommands& commands, std::size_t& row);
  void control(std::span<const double> commands);
  bool follow(const MotionCommands& commands, std::size_t& row);
  bool isSound() const;
  void take(Sample& sample);
  void write(double part, MotionTrack& track, std::size_t row) const;
  MotionOutcome stopped() const;

  RolloutOptions options_;
  BulletArm arm_;
  std::vector<Muscle> muscles_;
  std::vector<JointType> types_;
  std::vector<CommandKind> kinds_;
  std::vector<std::unique_ptr<MuscleController>> controllers_;
  std::unique_ptr<JointPositionController> pilot_;  ///< of the targets
  std::vector<double> commands_, later_;            ///< scratch, shape (muscles + lines)
  double delay_ = 0.0;                              ///< of the commands [s]
  std::unique_ptr<Sample> before_, now_;
  double origin_ = 0.0;  ///< time of step 0 [s]
  long steps_ = 0;
  int tick_ = 1;  ///< steps per period of the controllers
};

}  // namespace simgap
