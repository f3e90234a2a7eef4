// An arm as an internal model in another program: link simgap_simulate, give set-points, step, look.
//
//     step_arm data/arm/arm.yaml      # a line per tenth of a second
#include <cstdio>

#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/simulate/rollout.h"

int main(int argc, char** argv) try {
  if (argc != 2) throw simgap::ConfigError("expected one argument: an arm model (YAML)");
  const simgap::ArmModel model = simgap::readArm(simgap::YamlNode::load(argv[1]));
  simgap::Rollout arm(model, {});  // steps of 1 ms, controllers at 500 Hz
  const std::vector<simgap::CommandKind> kinds(model.muscles.size(), simgap::CommandKind::kSetpoint);
  std::vector<double> setpoints(model.muscles.size(), 0.0);
  arm.begin(kinds, {});
  for (int tick = 0; tick < 1000; ++tick) {
    setpoints.front() = tick < 500 ? 2.0 : 0.0;  // [rad], as any controller would have it
    if (!arm.step(setpoints)) throw simgap::NumericsError("the simulation blew up");
    if (tick % 100 == 99) {
      std::printf("%.3f s: %s at %.3f rad, %.2f N\n", arm.time(), model.muscles.front().name.c_str(),
                  arm.arm().shaftAngle(0), arm.arm().force(0));
    }
  }
  return 0;
} catch (const simgap::Error& error) {
  std::fprintf(stderr, "step_arm: %s\n", error.what());
  return static_cast<int>(error.code());
}
