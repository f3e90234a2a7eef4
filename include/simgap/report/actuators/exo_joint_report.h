/// \file
/// What `simulate` shows and writes of a joint of two pneumatic muscles and a motor (002 section III, fig. 8).
#pragma once

#include <string>

#include "simgap/report/table.h"
#include "simgap/simulate/exo_joint_study.h"

namespace simgap {

Json toJson(const ExoJoint& joint, const ExoJointCommands& commands, const ExoJointStudy& study);
/// The answer in a sentence, from the result's JSON.
std::string exoJointAnswer(const Json& result);
/// A row per controller, from the result's JSON; no rows where pressures were commanded.
Table exoControllerTable(const Json& result);
std::string exoJointText(const Json& result);

/// motion.csv (the first run) and, where a torque was desired, tracking.csv: all runs. \param rate  of the rows [Hz]
void writeExoJoint(const ExoJoint& joint, const ExoJointStudy& study, double rate, const RunDirectory& directory);

}  // namespace simgap
