/// \file
/// How a recorded pose is replayed on a simulated arm (001 section III-B).
#pragma once

#include <string>
#include <vector>

#include "simgap/core/bytes.h"
#include "simgap/core/yaml.h"
#include "simgap/simulate/bullet_arm.h"

namespace simgap {

/// Thresholds of the protocol; the defaults are the paper's, but for early acquisition.
struct PoseProtocol {
  double acquisition = 5.0;                ///< t_a [s]
  double settle = 5.0;                     ///< t_s [s]
  double steady = 0.5;                     ///< t_d [s]
  double max_shaft_error = 5.0 * kDegree;  ///< dG_max [rad]
  double max_velocity = 0.02;              ///< omega_max [rad/s]
  /// Leave acquisition once every shaft has stayed within max_shaft_error for early_hold; off reproduces the paper.
  bool early_acquisition = true;
  double early_hold = 0.1;  ///< [s]
  BulletArmOptions arm;

  /// Reads the `protocol:` block; keys that are missing keep their value. \throws ConfigError
  static PoseProtocol read(const YamlNode& node);
  std::string toYaml(const std::string& indent) const;  ///< the block's lines
  void validate() const;
};

enum class PoseStatus {
  kSteady,
  kAcquisitionError,  ///< a shaft is not where it should be when t_a ends; worst: the muscle, its error [rad]
  /// A joint never rested for t_d within t_s; worst: the joint that last moved, or crept, its speed [rad/s]
  kNotSteady,
  kNotFinite,      ///< the simulation blew up
  kNoEquilibrium,  ///< the potential energy has no minimum the arm would come to; worst_value: torque left [N m]
  kSkipped,        ///< not simulated, because an earlier pose of the individual was invalid
};
std::string_view toString(PoseStatus status);

/// How a pose ended.
struct PoseOutcome {
  PoseStatus status = PoseStatus::kSkipped;
  std::vector<JointPosition> joints;   ///< shape (joints); empty unless steady
  std::vector<double> shafts;          ///< shape (muscles) [rad], the angles actually reached
  std::vector<double> cord_expansion;  ///< shape (muscles), over the rest length
  int worst = -1;                      ///< muscle or joint, see PoseStatus
  double worst_value = 0.0;
  double settle_needed = 0.0;  ///< t_s within which a joint that creeps would have rested [s]; 0: not known
  double duration = 0.0;       ///< simulated time [s]
};

/// Between ranks.
void pack(Bytes& bytes, const PoseOutcome& outcome);
void unpack(BytesReader& from, PoseOutcome& outcome);

/// Resets the arm and replays one pose.
/// \param shafts  recorded shaft angles, shape (muscles) [rad]
PoseOutcome replayPose(BulletArm& arm, std::span<const double> shafts, const PoseProtocol& protocol);

}  // namespace simgap
