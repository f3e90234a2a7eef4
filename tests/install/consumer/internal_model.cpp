// A program with an arm as its internal model, as a user of the installed package writes it: what would the arm do?
//
//     internal_model arm.yaml
#include <simgap/simulate/arm.h>
#include <cmath>
#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  if (argc != 2) return 2;
  simgap::Arm arm(argv[1]);
  std::vector<double> setpoints(arm.muscles().size(), 0.0);
  arm.reset(simgap::Arm::Command::kSetpoint);
  for (int i = 0; i < 1000; ++i) {
    setpoints.front() = i < 500 ? 2.0 : 0.0;
    arm.step(setpoints);
    if (i % 250 == 249)
      std::printf("%.3f s: %s %.3f rad, %.1f N\n", arm.time(), arm.muscles().front().c_str(), arm.shaft(0),
                  arm.force(0));
  }
  const bool right = std::fabs(arm.shaft(0)) < 0.1 && std::fabs(arm.time() - 1.0) < 1e-9 && arm.joint(0).size() == 4;
  try {
    arm.step({1.0});
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());  // found 1 commands, expected 11
    return right ? 0 : 1;
  }
  return 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "internal_model: %s\n", error.what());
  return 1;
}
