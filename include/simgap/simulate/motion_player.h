/// \file
/// A recorded motion played to a simulated arm: its commands in, what was measured meanwhile out.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/core/bytes.h"
#include "simgap/measure/motion_set.h"
#include "simgap/simulate/possible_commands.h"
#include "simgap/simulate/rollout.h"

namespace simgap {

struct MotionOptions {
  RolloutOptions rollout{.step = 0.002, .controllers = {}};
  double settle = 1.0;   ///< [s] at rest under the first commands before a motion begins, where no start was measured
  double restart = 0.0;  ///< [s] longer motions begin anew from measured states (motion_restart.h); 0: never

  /// Reads the `motions:` block's keys of it; keys that are missing keep their value. \throws ConfigError
  static MotionOptions read(const YamlNode& node);
  /// With steps of the bodies twice as long, where the controllers' period allows that: joints differ by less than
  /// a tenth of a degree, for half the time.
  MotionOptions coarser() const;
  std::string toYaml(const std::string& indent) const;  ///< the block's lines
};

/// What the arm did, at the times at which the real one was measured, as far as it was played.
struct PlayedMotion {
  bool valid = false;
  MotionOutcome outcome;
  std::vector<JointPosition> joints;  ///< shape (frames played, joints), as markers show them
  Eigen::MatrixXd shafts;             ///< shape (muscles, rows played) [rad]
  Eigen::MatrixXd currents;           ///< shape (muscles, rows played) [A]
};
/// Between ranks.
void pack(Bytes& bytes, const PlayedMotion& played);
void unpack(BytesReader& from, PlayedMotion& played);

/// Checked against a model, and cut at restarts. \throws DataError: a voltage beyond the supply, a force that pushes
MotionSet readMotionsFor(const ArmModel& model, const YamlNode& root, const std::filesystem::path& file,
                         const TableReader& table, double restart = 0.0);

/// What playing a recorded motion needs of it besides its commands, found once for many models.
struct PlayableMotion {
  /// \param recorded  must outlive it
  PlayableMotion(const RecordedMotion& recorded, const std::vector<Joint>& joints);

  const RecordedMotion* motion;
  std::vector<JointPosition> rest;       ///< joints while the first commands last, mean; empty: too few frames show it
  std::vector<double> shafts, currents;  ///< means meanwhile; NaN: not measured [rad], [A]
};

/// Plays recorded motions, one at a time; a worker keeps one.
class MotionPlayer {
 public:
  MotionPlayer(const ArmModel& model, const MotionOptions& options);
  /// Another model of as many joints and muscles.
  void setModel(const ArmModel& model);
  /// Begins at rest under the first commands: near where joints and shafts were measured then, which dry friction may
  /// hold beside their equilibrium, and after `settle` of simulated time; or in the measured start.
  /// \param capture_delay  the frame at time t on the capture's clock was taken at t + capture_delay [s]
  /// \param until  what was measured later, by its own clock, is not played [s]
  void play(const PlayableMotion& motion, double capture_delay, PlayedMotion& played, double until = kInfinity);

 private:
  MotionStart startOf(const PlayableMotion& motion) const;

  ArmModel model_;
  MotionOptions options_;
  Rollout rollout_;
  MotionTrack track_;
};

/// "the simulation blew up 1.20 s after the start: shoulder; …": why a motion could not be played.
std::string describeFailure(const PlayedMotion& played, const PoseLayout& layout, const MotionOptions& options);

}  // namespace simgap
