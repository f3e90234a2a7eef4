// <actuator>: what pulls. MuJoCo has one default for actuators of all kinds; its shortcuts (motor, position, ...) set
// some of its numbers over and leave the others as they were, in the defaults of a class as in the element itself.
#include <fmt/format.h>

#include "mjcf_robot.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

/// What an actuator says, and before it the defaults of its class.
struct Law {
  double gain = 1.0;
  std::array<double, 3> bias = {0.0, 0.0, 0.0};  ///< bias[2] > 0: MuJoCo's damping ratio of a position servo
  std::string gain_type = "fixed", bias_type = "none", dynamics = "none";
};

/// An own list may say only the first numbers: the others stay those of the class.
template <std::size_t N>
void setLeading(const MjcfNode& layer, const char* attribute, std::array<double, N>& values) {
  const std::vector<double> said = layer.numbers(attribute);
  std::copy_n(said.begin(), std::min(said.size(), N), values.begin());
}

void addGeneral(const MjcfNode& layer, Law& law) {
  const auto word = [&](const char* attribute, std::string& value) {
    if (layer.has(attribute)) value = layer.text(attribute);
  };
  word("gaintype", law.gain_type);
  word("biastype", law.bias_type);
  word("dyntype", law.dynamics);
  std::array<double, 1> gain = {law.gain};
  setLeading(layer, "gainprm", gain);
  law.gain = gain[0];
  setLeading(layer, "biasprm", law.bias);
}

void addPosition(const MjcfNode& layer, Law& law) {
  law.gain = layer.number("kp", law.gain);
  law.bias[1] = -law.gain;
  if (layer.has("kv")) law.bias[2] = -layer.nonNegative("kv", 0.0);
  if (layer.has("dampratio")) law.bias[2] = layer.nonNegative("dampratio", 0.0);
  if (layer.has("timeconst")) law.dynamics = layer.number("timeconst", 0.0) == 0.0 ? "none" : "filterexact";
  law.gain_type = "fixed";
  law.bias_type = "affine";
}

/// As mjs_setToMotor and its like (MuJoCo, user_api.cc).
void addLayer(const MjcfNode& layer, Law& law) {
  const std::string tag = layer.tag();
  if (tag == "general") {
    addGeneral(layer, law);
  } else if (tag == "motor") {
    law.gain = 1.0;
    law.gain_type = "fixed";
    law.bias_type = law.dynamics = "none";
  } else if (tag == "position" || tag == "intvelocity") {
    addPosition(layer, law);
    if (tag == "intvelocity") law.dynamics = "integrator";
  } else if (tag == "velocity") {
    if (layer.has("kv")) law.gain = layer.nonNegative("kv", 1.0);
    law.bias = {0.0, 0.0, -law.gain};
    law.gain_type = "fixed";
    law.bias_type = "affine";
    law.dynamics = "none";
  } else {
    law.gain_type = law.bias_type = tag;  // a muscle, a cylinder, …: its numbers are no gain and bias
  }
}

void readLaw(const MjcfNode& node, MjcfActuator& actuator) {
  Law law;
  for (const MjcfNode& layer : node.layers()) addLayer(layer, law);
  const bool biased = law.bias_type == "affine";
  actuator.affine = law.gain_type == "fixed" && (biased || law.bias_type == "none") && actuator.tag != "intvelocity";
  actuator.gain = law.gain;
  if (biased) actuator.bias = law.bias;
  if (!actuator.affine) {  // what only its own law would need is said once, where the arm is built
    for (const MjcfNode& layer : node.layers()) {
      for (const auto* a = layer.xml().FirstAttribute(); a; a = a->Next()) layer.find(a->Name());
    }
    return;
  }
  if (biased && actuator.bias[1] == -actuator.gain && actuator.bias[2] > 0.0) {
    actuator.bias[2] = 0.0;
    node.remark(actuator.tag == "general" ? "biasprm" : "dampratio",
                "a damping ratio: left out (motions only, not where the robot rests)");
  }
  if (law.dynamics != "none") {
    node.remark(actuator.tag == "general" ? "dyntype" : "timeconst", "left out: the control acts at once");
  }
  if (node.has("inheritrange")) node.remark("inheritrange", "left out: no limit of a control", false);
}

/// What an actuator acts on that is neither a line nor a joint.
std::string_view actsOn(const MjcfNode& node) {
  if (node.has("site")) return "it pushes at a site; lines and joints are what is driven here";
  if (node.has("cranksite")) return "it drives a slider-crank; lines and joints are what is driven here";
  if (node.has("body")) return "it sticks to what a body touches; contacts are not modelled";
  return "it names nothing that it acts on";
}

/// Limits of a control are not modelled, which is seen at once where no control is 0.
void nameControlLimits(const MjcfNode& node) {
  const auto range = node.limits("ctrllimited", "ctrlrange");
  const bool no_zero = range && ((*range)[0] > 0.0 || (*range)[1] < 0.0);
  for (const char* control : {"ctrllimited", "ctrlrange", "actlimited", "actrange"}) {
    if (!node.has(control)) continue;
    const bool acts = no_zero && std::string_view(control) == "ctrlrange";
    node.remark(
        control,
        acts ? "left out: it leaves out 0, which MuJoCo takes to its nearer end" : "left out: no limit of a control",
        acts);
  }
}

/// Groups of actuators that are switched off.
std::set<std::int64_t> disabledGroups(MjcfFile& file) {
  std::set<std::int64_t> groups;
  for (const MjcfNode& option : file.sections("option")) {
    const std::vector<double> said = option.numbers("actuatorgroupdisable");
    if (!option.has("actuatorgroupdisable")) continue;
    groups.clear();
    for (const double group : said) groups.insert(static_cast<std::int64_t>(group));
  }
  return groups;
}

void readActuator(MjcfFile& file, const MjcfNode& node, const std::set<std::int64_t>& disabled, MjcfRobot& robot) {
  MjcfActuator actuator;
  actuator.tag = node.tag();
  actuator.name = node.newName("actuator");
  actuator.tendon = node.text("tendon");
  // The same as joint but for balls, which no actuator turns here.
  actuator.joint = node.has("jointinparent") ? node.text("jointinparent") : node.text("joint");
  actuator.place = file.xml().place(node.xml());
  if (actuator.tendon.empty() && actuator.joint.empty()) {
    return node.remarkAll(actuator.tag + " (actuator)", fmt::format("left out: {}", actsOn(node)));
  }
  if (robot.loose.contains("tendon " + actuator.tendon) || robot.loose.contains("joint " + actuator.joint)) {
    return node.remarkAll(actuator.tag + " (actuator)", "left out: it moves a loose body that is left out");
  }
  if (disabled.contains(static_cast<std::int64_t>(node.number("group", 0.0)))) {
    return node.remarkAll(actuator.tag + " (actuator)",
                          "left out: its group is switched off (option actuatorgroupdisable)", false);
  }
  const std::vector<double> gear = node.numbers("gear");
  if (!gear.empty()) actuator.gear = gear[0];
  actuator.force_range = node.limits("forcelimited", "forcerange");
  readLaw(node, actuator);
  nameControlLimits(node);
  robot.actuators.push_back(actuator);
}

}  // namespace

void readMjcfActuators(MjcfFile& file, MjcfRobot& robot) {
  const std::set<std::int64_t> disabled = disabledGroups(file);
  for (const MjcfNode& section : file.sections("actuator")) {
    for (const MjcfNode& node : section.children()) readActuator(file, node, disabled, robot);
  }
}

}  // namespace simgap
