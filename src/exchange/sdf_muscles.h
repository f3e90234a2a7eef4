/// \file
/// Muscles that CARDSflow's plugin for Gazebo adds to a model of SDF.
#pragma once

#include "link_tree.h"

namespace simgap {

/// Adds a motorised muscle per `myoMuscle` of the model's plugins. \throws DataError: no link of that name, no numbers,
/// or fewer than two points
void readSdfMuscles(const XmlElement& model, const LinkTree& tree, XmlRobot& xml, ArmModel& arm);

}  // namespace simgap
