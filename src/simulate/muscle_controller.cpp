#include "simgap/simulate/muscle_controller.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "controllers/open_loop.h"
#include "controllers/shaft_position.h"
#include "controllers/state_space_force.h"

namespace simgap {

namespace {

template <std::size_t N>
void readRates(const YamlNode& node, const char* key, std::array<double, N>& rates) {
  const auto list = node.find(key);
  if (!list) return;
  const std::vector<YamlNode> items = list->items();
  if (items.size() != N) list->fail(fmt::format("found {} poles, expected {}", items.size(), N));
  for (std::size_t i = 0; i < N; ++i) rates[i] = items[i].number(kPositive);
}

}  // namespace

ControllerOptions ControllerOptions::read(const YamlNode& node) {
  ControllerOptions options;
  options.rate = node.findQuantity("rate", "Hz", kPositive).value_or(options.rate);
  if (const auto gain = node.find("shaft_gain_V_rad")) options.shaft_gain = gain->number(kPositive);
  if (const auto stiffness = node.find("joint_stiffness_Nm_rad"))
    options.joint_stiffness = stiffness->number(kPositive);
  if (const auto damping = node.find("joint_damping_Nms_rad")) options.joint_damping = damping->number(kNonNegative);
  options.least_force = node.findQuantity("least_force", "N", kNonNegative).value_or(options.least_force);
  readRates(node, "force_poles_1_s", options.force_rates);
  readRates(node, "observer_poles_1_s", options.observer_rates);
  return options;
}

std::string ControllerOptions::toYaml() const {
  return fmt::format(
      "controllers: {{rate_Hz: {}, shaft_gain_V_rad: {},\n  force_poles_1_s: [{}], observer_poles_1_s: [{}],\n"
      "  joint_stiffness_Nm_rad: {}, joint_damping_Nms_rad: {}, least_force_N: {}}}\n",
      rate, shaft_gain, fmt::join(force_rates, ", "), fmt::join(observer_rates, ", "), joint_stiffness, joint_damping,
      least_force);
}

std::unique_ptr<MuscleController> makeController(CommandKind kind, const Muscle& muscle,
                                                 const ControllerOptions& options) {
  switch (kind) {
    case CommandKind::kSetpoint:
      return std::make_unique<ShaftPositionController>(options.shaft_gain);
    case CommandKind::kForce:
      return std::make_unique<StateSpaceForceController>(muscle, options);
    case CommandKind::kVoltage:
      break;
  }
  return std::make_unique<OpenLoopController>();
}

}  // namespace simgap
