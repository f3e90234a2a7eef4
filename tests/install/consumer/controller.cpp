// A controller as a user of the installed package writes it.
#include <simgap/model/actuator/feed_forward.h>
#include <simgap/model/actuator/pam.h>
#include <simgap/model/actuator/torque_split.h>
#include <simgap/model/actuator/trajectory_control.h>
#include <cmath>
#include <cstdio>
#include <optional>

int main() {
  simgap::DriveFeedForward drive;
  drive.k_a = 2.0;
  drive.friction = {.n_c1 = 0.1, .n_c2 = 0.5, .n_s1 = 0.1, .n_s2 = 0.5, .k_v = 0.01, .v_s = 1.0, .delta = 1.0};
  simgap::DirectionHold hold(0.2);
  const double current = drive.effort(10.0, 30.0, hold.update(30.0));  // (10 + 0.1 * 10 + 0.5 + 0.01 * 30) / 2
  simgap::Pam muscle;
  muscle.a = 0.02, muscle.b = -0.01, muscle.c = 0.001, muscle.k = 1e5;
  const auto force = muscle.force(4e5, 0.05);
  const auto pressure = force ? muscle.pressure(*force, 0.05) : std::nullopt;
  muscle.highest = muscle.slack();
  simgap::AntagonistJoint joint{muscle, muscle, 0.04, 0.25, 0.05, 0.05};
  simgap::TorqueSplit split(joint, {.highest_pressure = 6e5, .motor_limit = 2.0});
  const simgap::TorqueShares shares = split.update(3.0, 0.0, 2.0, 0.002);
  simgap::TrajectoryController controller({.current_limit = 40.0}, drive, 1.0);
  const bool followed = controller.give(10.0, 30.0) == current;
  const bool split_right =
      std::fabs(joint.torque(shares.flexor_pressure, shares.extensor_pressure, 0.0) - 3.0) < 1e-9 &&
      shares.motor == 1.0 && shares.missing == 0.0;
  const bool right = followed && split_right && std::fabs(current - 5.9) < 1e-12 && hold.update(0.1) == 1.0 &&
                     pressure && std::fabs(*pressure - 4e5) < 1e-3;
  std::printf("%.12g A, %.6g N, %.12g Pa\n", current, force.value_or(0.0), pressure.value_or(0.0));
  return right ? 0 : 1;
}
