/// \file
/// data/robot: a robot of four hinges as somebody has drawn it, the log of one trajectory to fit it to and another's to
/// judge it by; by tests/reality. make_robot_data DIR
#include <cstdio>
#include <filesystem>

#include "reality/robot_rig.h"
#include "simgap/core/run_directory.h"

int main(int argc, char** argv) {
  using namespace simgap;
  if (argc != 2) {
    std::fputs("usage: make_robot_data DIR\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  const reality::Robot robot = reality::randomRobot(24, 4, false, false);
  reality::RobotRigOptions rig;
  rig.rate = 50.0;
  rig.duration = 60.0;
  rig.position_quantum = 1e-4;
  writeFileAtomically(folder / "robot.urdf", reality::drawnUrdf(robot, 24));
  writeFileAtomically(folder / "log.csv", reality::recordRobot(robot, rig, 1));
  writeFileAtomically(folder / "other_log.csv", reality::recordRobot(robot, rig, 2));
  return 0;
}
