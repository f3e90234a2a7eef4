// What an ampere is worth, from currents of robots whose torques come from Lagrange's equations.
#include "simgap/fit/dynamics/torque_constants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "reality/robot_rig.h"
#include "simgap/core/error.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "simgap/measure/logs/joined_logs.h"
#include "support/files.h"
#include "support/robot_logs.h"

namespace simgap {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct LoadedRobot {
  reality::Robot robot;
  std::vector<double> constants;
  KnownPayload payload;
};

LoadedRobot drawnRobot(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  LoadedRobot drawn{reality::randomRobot(seed, 2 + static_cast<int>(seed % 4), false, false), {}, {}};
  for (std::size_t k = 0; k < drawn.robot.links.size(); ++k) drawn.constants.push_back(5.0 + 15.0 * unit(random));
  const double heaviest = drawn.robot.links.front().mass;
  drawn.payload = {"link" + std::to_string(drawn.robot.links.size()),
                   (0.3 + 0.4 * unit(random)) * heaviest,
                   {0.1 + 0.1 * unit(random), 0.05, 0.1 * unit(random)},
                   {false, true}};
  return drawn;
}

/// With a point mass on the last link.
reality::Robot carrying(const LoadedRobot& drawn) {
  reality::Robot robot = drawn.robot;
  reality::RobotLink& link = robot.links.back();
  const double mass = link.mass + drawn.payload.mass;
  const Eigen::Vector3d centre = (link.mass * link.centre + drawn.payload.mass * drawn.payload.centre) / mass;
  const auto shifted = [&](double m, const Eigen::Vector3d& at) -> Eigen::Matrix3d {
    const Eigen::Vector3d d = at - centre;
    return m * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  };
  link.inertia += shifted(link.mass, link.centre) + shifted(drawn.payload.mass, drawn.payload.centre);
  link.mass = mass;
  link.centre = centre;
  return robot;
}

RobotLog recorded(const LoadedRobot& drawn, const ArmModel& arm, double noise = 0.02) {
  reality::RobotRigOptions rig;
  rig.torque_noise = noise;
  rig.current = true;
  std::vector<LogTable> logs;
  logs.push_back({CsvTable::parse(recordRobot(drawn.robot, rig, 1, drawn.constants), "free.csv"), {}});
  logs.push_back({CsvTable::parse(recordRobot(carrying(drawn), rig, 2, drawn.constants), "loaded.csv"), {}});
  return readRobotLog(joinedLogs(std::move(logs)).table, loggedJoints(arm));
}

TEST(TorqueConstants, LogsWithAndWithoutALoadTellThem) {
  int inside = 0, count = 0, bases_inside = 0, bases = 0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const LoadedRobot drawn = drawnRobot(seed);
    const ArmModel arm = test::drawnArm(drawn.robot, seed);
    RobotFitOptions options;
    options.payload = drawn.payload;
    const RobotFit found = fitRobot(arm, recorded(drawn, arm), options);
    for (std::size_t c = 0; c < drawn.constants.size(); ++c) {
      const Estimate& k = found.constants[c];
      EXPECT_NEAR(k.value, drawn.constants[c], 0.01 * drawn.constants[c]) << "seed " << seed << ", joint " << c;
      inside += k.lower95 <= drawn.constants[c] && drawn.constants[c] <= k.upper95;
      ++count;
    }
    const Eigen::VectorXd truth = test::trueBase(drawn.robot, arm);
    for (Eigen::Index k = 0; k < truth.size(); ++k) {
      const Estimate& e = found.fit.base[static_cast<std::size_t>(k)].estimate;
      if (!e.identifiable) continue;
      bases_inside += e.lower95 <= truth[k] && truth[k] <= e.upper95;
      ++bases;
    }
  }
  std::printf("in their 95 %% intervals: %d of %d torque constants, %d of %d base parameters\n", inside, count,
              bases_inside, bases);
  EXPECT_GE(inside, 0.85 * count);
  EXPECT_GE(bases_inside, 0.9 * bases);
}

std::string refusal(const KnownPayload& payload, std::uint64_t seed) {
  const LoadedRobot drawn = drawnRobot(seed);
  const ArmModel arm = test::drawnArm(drawn.robot, 1);
  RobotFitOptions options;
  options.payload = payload;
  return test::errorOf([&] { fitRobot(arm, recorded(drawn, arm), options); });
}

TEST(TorqueConstants, ALoadThatMakesAnotherRobotIsSaid) {
  KnownPayload in_tonnes = drawnRobot(4).payload;
  in_tonnes.mass *= 1e-3;
  EXPECT_THAT(refusal(in_tonnes, 4), AllOf(HasSubstr("times what its file says"), HasSubstr("is it in kg and m?")));
}

TEST(TorqueConstants, AJointThatHardlyFeelsTheLoadIsSaid) {
  LoadedRobot drawn = drawnRobot(5);
  drawn.payload.mass *= 0.1;
  const ArmModel arm = test::drawnArm(drawn.robot, 1);
  RobotFitOptions options;
  options.payload = drawn.payload;
  EXPECT_THAT(test::errorOf([&] { fitRobot(arm, recorded(drawn, arm, 1.0), options); }),
              AllOf(HasSubstr("the torque constant of j1 is not found"), HasSubstr("hardly feels the load")));
}

TEST(TorqueConstants, AnUnknownBodyIsRefused) {
  KnownPayload payload = drawnRobot(4).payload;
  payload.body = "gripper";
  EXPECT_THAT(refusal(payload, 4), HasSubstr("found the body gripper, expected one of"));
}

}  // namespace
}  // namespace simgap
