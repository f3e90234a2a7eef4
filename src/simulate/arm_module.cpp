// The shared library behind simgap/simulate/arm.h.
#include <fmt/format.h>

#include <stdexcept>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/arm.h"
#include "simgap/simulate/possible_commands.h"
#include "simgap/simulate/rollout.h"

namespace simgap {

struct Arm::Simulation {
  ArmModel model;
  Rollout rollout;
  std::vector<std::string> muscles, joints;
  std::vector<CommandKind> kinds;
  std::vector<const PassiveTendon*> lines;  // of the model, that take a command

  Simulation(const ArmModel& arm, const RolloutOptions& options)
      : model(arm), rollout(arm, options), kinds(arm.muscles.size(), CommandKind::kSetpoint) {
    for (const PassiveTendon* line : commandedLines(model)) lines.push_back(line);
    for (const Muscle& muscle : arm.muscles) muscles.push_back(muscle.name);
    for (const Joint& joint : arm.joints) joints.push_back(joint.name);
    rollout.begin(kinds, {});
  }
};

namespace {

RolloutOptions rolloutOptions(const Arm::Options& options) {
  RolloutOptions rollout;
  rollout.step = options.step;
  rollout.controllers.rate = options.controller_rate;
  rollout.controllers.shaft_gain = options.shaft_gain;
  return rollout;
}

void expectIndex(std::size_t index, std::size_t count, const char* what) {
  if (index < count) return;
  throw std::runtime_error(fmt::format("found {} {}, expected one below {}", what, index, count));
}

}  // namespace

Arm::Arm(const std::string& model, const Options& options)
    : simulation_(std::make_unique<Simulation>(readArm(YamlNode::load(model)), rolloutOptions(options))) {}
Arm::~Arm() = default;
Arm::Arm(Arm&&) noexcept = default;
Arm& Arm::operator=(Arm&&) noexcept = default;

const std::vector<std::string>& Arm::muscles() const { return simulation_->muscles; }
const std::vector<std::string>& Arm::joints() const { return simulation_->joints; }

void Arm::reset(Command command) {
  const CommandKind kind = command == Command::kSetpoint  ? CommandKind::kSetpoint
                           : command == Command::kVoltage ? CommandKind::kVoltage
                                                          : CommandKind::kForce;
  simulation_->kinds.assign(simulation_->muscles.size(), kind);
  simulation_->rollout.begin(simulation_->kinds, {});
}

void Arm::step(const std::vector<double>& commands) {
  const std::vector<Muscle>& muscles = simulation_->model.muscles;
  const std::vector<const PassiveTendon*>& lines = simulation_->lines;
  if (commands.size() != muscles.size() + lines.size()) {
    throw std::runtime_error(
        fmt::format("found {} commands, expected {}", commands.size(), muscles.size() + lines.size()));
  }
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const std::string problem = problemOf(*lines[l], commands[muscles.size() + l]);
    if (!problem.empty()) throw std::runtime_error(fmt::format("{}: {}", lines[l]->name, problem));
  }
  for (std::size_t m = 0; m < muscles.size(); ++m) {
    const std::string problem = problemOf(muscles[m], simulation_->kinds[m], commands[m]);
    if (!problem.empty()) throw std::runtime_error(fmt::format("{}: {}", muscles[m].name, problem));
  }
  if (!simulation_->rollout.step(commands)) {
    throw std::runtime_error(
        fmt::format("the simulation blew up at {:g} s; a smaller step may hold it", simulation_->rollout.time()));
  }
}

double Arm::time() const { return simulation_->rollout.time(); }

std::vector<double> Arm::joint(std::size_t joint) const {
  expectIndex(joint, simulation_->joints.size(), "joint");
  return kindOf(simulation_->model.joints[joint].type).cells(simulation_->rollout.arm().jointPosition(joint));
}

std::vector<double> Arm::velocity(std::size_t joint) const {
  expectIndex(joint, simulation_->joints.size(), "joint");
  const Eigen::Vector3d velocity = simulation_->rollout.arm().jointVelocity(joint);
  return {velocity.data(), velocity.data() + simulation_->model.joints[joint].degreesOfFreedom()};
}

double Arm::shaft(std::size_t muscle) const {
  expectIndex(muscle, simulation_->muscles.size(), "muscle");
  return simulation_->rollout.arm().shaftAngle(muscle);
}
double Arm::force(std::size_t muscle) const {
  expectIndex(muscle, simulation_->muscles.size(), "muscle");
  return simulation_->rollout.arm().force(muscle);
}
double Arm::current(std::size_t muscle) const {
  expectIndex(muscle, simulation_->muscles.size(), "muscle");
  return simulation_->rollout.arm().current(muscle);
}

}  // namespace simgap
