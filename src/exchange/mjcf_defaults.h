/// \file
/// Which element of a <default> speaks about an element of the model.
#pragma once

#include <set>
#include <string>

namespace simgap {

/// Actuators, tendons and equalities of all kinds have one default each in MuJoCo, whatever the tag that states it.
/// \param parent  tag of what it stands in: a section, a body, <default>. \returns empty: nothing does
inline std::string defaultTag(const std::string& parent, const std::string& tag) {
  static const std::set<std::string> actuators = {"general", "motor",    "position", "velocity", "intvelocity",
                                                  "damper",  "cylinder", "muscle",   "adhesion", "plugin"};
  if (parent == "tendon" || parent == "equality" || parent == "actuator") return parent;
  if (parent == "spatial" || parent == "fixed") return "";  // names of sites, geoms and joints, no such elements
  if (parent == "default" && actuators.contains(tag)) return "actuator";
  return tag;
}

}  // namespace simgap
