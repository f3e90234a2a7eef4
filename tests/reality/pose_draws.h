/// \file
/// Arms with something hidden in them, and what a rig records of them. This file and its source fix, once for all, what
/// is drawn: designs, noise, which effect on which target and how large. Diagnoses see only the model and the poses.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "reality/arm_rig.h"

namespace simgap::reality {

/// Something the hand-measured arm does not know.
struct HiddenCause {
  std::string effect;      ///< a name of the catalogue
  std::string target;      ///< as in the model file; empty: the whole
  double magnitude = 0.0;  ///< in the unit of the law that hides it
  double moment = 0.0;     ///< of a slip [s]
  /// The same as the fitted parameters of the catalogue's effect; empty where its law is another one.
  std::vector<double> parameters = {};
};

struct TimedPose {
  double time;                 ///< [s]
  std::vector<double> shafts;  ///< as logged [rad]
  Configuration joints;        ///< as captured
};

struct PoseDraw {
  Arm nominal, truth;
  std::vector<HiddenCause> hidden;
  std::vector<TimedPose> poses;
  std::vector<TimedPose> fresh;  ///< of another session with the same causes
};

struct PoseDrawOptions {
  int poses = 80;
  int fresh = 0;
  int causes = 1;            ///< 0: nothing is hidden
  bool weak = false;         ///< magnitudes near what such a set can just reveal; else 1.4 to 2.6 times that
  std::string effect = {};   ///< of the first cause; empty: drawn
  const Arm* arm = nullptr;  ///< whose twin it is, which has to have the targets; null: the reference arm
  int flipped = 0;           ///< poses turned by a confusion of markers
  bool cured = false;        ///< what is hidden is taken away before the fresh poses, which are then recorded later
  std::vector<std::vector<double>> commands = {};  ///< shafts [rad] of the first fresh poses; the others are drawn
  std::function<void(Arm&)> change = {};  ///< what is done to the arm before the fresh poses, which then are later ones
};

/// A pure function of its arguments.
PoseDraw drawPoses(std::uint64_t seed, const PoseDrawOptions& options);

/// The effects that are drawn from where none is asked for, and those that have to be.
std::vector<std::string> hiddenEffects();

/// A pose set as a file: pose, time_s, shafts, joints.
std::string posesCsv(const Arm& arm, const std::vector<TimedPose>& poses);

}  // namespace simgap::reality
