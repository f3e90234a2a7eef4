// Writes the sample data of data/ that need no robot, from the simulators of tests/reality:
//   make_sample_data DIRECTORY      logs/*.csv, eeg/imagery*, exoskeleton/log.csv,
//                                   boards/{left,right,bar-left,bar-right}/*.pgm
// data/logs, data/eeg and data/exoskeleton hold tables packed (gzip -9n), data/boards the pictures as PNG.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "reality/board_scene.h"
#include "reality/drive_rig.h"
#include "reality/eeg.h"
#include "reality/exo_joint_rig.h"
#include "reality/motor_log.h"
#include "reality/pam_rig.h"

namespace {

using namespace simgap::reality;

void writeLogs(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const MotorDesign steps{.seconds = 4.0, .rate = 500.0, .current_noise = 0.02, .velocity_noise = 0.5, .seed = 11};
  std::ofstream(folder / "motor.csv") << simulateMotor({}, steps).csv();

  MotorTruth geared;
  geared.ratio = 72.0, geared.efficiency = 0.72;
  geared.gear_coulomb = 0.04, geared.gear_viscous = 0.003, geared.gear_inertia = 2e-3;
  MotorDesign loads = steps;
  loads.load = 0.5, loads.seed = 12;
  std::ofstream(folder / "gearbox.csv") << simulateMotor(geared, loads).csv();

  PamTruth muscle;
  std::ofstream(folder / "muscle-curves.csv") << recordPam(muscle, {.sessions = 3,
                                                                    .rows = 200,
                                                                    .rate = 10.0,
                                                                    .force_noise = 0.5,
                                                                    .pressure_noise = 0.0,
                                                                    .contraction_noise = 0.0,
                                                                    .seed = 13})
                                                     .csv();
  muscle.tendon = 20000.0;
  std::ofstream(folder / "muscle.csv")
      << recordPam(muscle, {.sessions = 4, .rows = 600, .rate = 20.0, .seed = 14}).csv();

  // A cable that is soft at first and stiffens (6 mrad under large loads), and encoders at both of its ends.
  constexpr double kStretch = 0.006;
  DriveRig cable;
  cable.rows = 12000, cable.seed = 31;
  std::ofstream(folder / "both-angles.csv") << csvWithMotorAngle(recordDrive(cable, {}), cable.ratio, kStretch);
  cable.rows = 6000, cable.seed = 32;
  std::ofstream(folder / "both-angles-later.csv") << csvWithMotorAngle(recordDrive(cable, {}), cable.ratio, kStretch);
}

void writeEeg(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  EegDesign design{.channels = 8, .rate = 96.0, .trials = 24, .trial_s = 3.0, .seed = 1};
  std::ofstream(folder / "imagery.csv") << recordEeg(design).csv();
  design.trials = 12, design.seed = 2;
  const EegTable later = recordEeg(design);
  std::ofstream(folder / "imagery-later.csv") << later.csv();
  std::ofstream(folder / "imagery-later.edf", std::ios::binary) << later.edf(false, true);
}

/// The joint of data/exoskeleton/joint.yaml as it was built: muscles a little thinner, softer tendons.
void writeExoskeleton(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  ExoRig rig;
  rig.diameter = 0.0293, rig.braid_angle = 0.445, rig.tendon = 33000.0;
  // Hands move it, too: without them the angle would follow from both pressures, and say nothing more.
  const auto inputs = [](double t) -> std::array<double, 4> {
    return {3.0e5 + 2.6e5 * std::sin(0.61 * t), 2.8e5 + 2.6e5 * std::sin(0.43 * t + 1.3), 0.0,
            45.0 * std::sin(1.37 * t)};
  };
  std::ofstream(folder / "log.csv") << recordExoRig(rig, inputs, 60.0, 50.0, 5e-4).csv(0.2, 2e-4, 400.0, 21);
}

/// A board turned about the cameras' common view: place [m], turn [rad].
struct BoardView {
  double x, y, z, tilt, pan, roll;
};

constexpr std::array<BoardView, 16> kViews = {{{0.08, 0.00, 0.75, 0.0, 0.0, 0.0},
                                               {0.00, 0.05, 0.80, 0.4, 0.1, 0.1},
                                               {0.16, -0.05, 0.80, -0.4, 0.2, -0.1},
                                               {0.08, 0.10, 0.90, 0.3, -0.4, 0.3},
                                               {0.12, -0.12, 0.95, -0.3, 0.4, -0.3},
                                               {0.22, 0.04, 0.90, 0.1, 0.5, 0.2},
                                               {-0.04, -0.04, 0.90, -0.2, -0.5, 0.0},
                                               {0.10, 0.14, 1.00, 0.5, 0.0, 0.6},
                                               {0.02, -0.14, 1.05, -0.5, 0.1, -0.6},
                                               {0.24, 0.12, 1.05, 0.2, 0.3, 1.0},
                                               {0.18, -0.16, 1.10, -0.2, -0.3, -1.0},
                                               {0.06, 0.02, 0.65, 0.2, 0.2, 0.05},
                                               {0.14, 0.03, 0.70, -0.3, -0.2, 1.5},
                                               {0.04, 0.16, 1.10, 0.6, -0.2, 0.2},
                                               {0.28, -0.04, 1.10, 0.0, 0.6, -0.2},
                                               {-0.06, 0.10, 1.05, 0.3, -0.6, 0.4}}};

void writeBoards(const std::filesystem::path& folder) {
  for (const char* side : {"left", "right", "bar-left", "bar-right"})
    std::filesystem::create_directories(folder / side);
  const StereoLenses lenses = standardLenses();
  Eigen::Isometry3d right = Eigen::Isometry3d::Identity();
  right.linear() = lenses.rotation;
  right.translation() = lenses.translation;
  const BoardPlate board;
  for (std::size_t i = 0; i < kViews.size(); ++i) {
    const BoardView& v = kViews[i];
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        (Eigen::AngleAxisd(v.tilt, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(v.pan, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(v.roll, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    pose.translation() = Eigen::Vector3d(v.x, v.y, v.z) - pose.linear() * Eigen::Vector3d(0.1, 0.0625, 0.0);
    char name[16];
    std::snprintf(name, sizeof name, "%02zu.pgm", i);
    drawBoard(lenses.left, board, pose).writePgm(folder / "left" / name);
    drawBoard(lenses.right, board, right * pose).writePgm(folder / "right" / name);
  }
  const Light light{.read_noise = 0.0, .shot_noise = 0.0};
  const Camera left_camera(lenses.left, light), right_camera(lenses.right, light);
  for (int i = 0; i < 4; ++i) {  // spheres 0.300 m apart
    const Eigen::Vector3d middle(0.08, 0.02 * i - 0.03, 1.0 + 0.05 * i),
        half(0.15 * std::cos(0.3 * i), 0.15 * std::sin(0.3 * i), 0.0);
    std::vector<Sphere> spheres{{middle - half}, {middle + half}};
    const std::string name = "0" + std::to_string(i) + ".pgm";
    left_camera.render({spheres}, {}, 1).writePgm(folder / "bar-left" / name);
    for (Sphere& sphere : spheres) sphere.centre = right * sphere.centre;
    right_camera.render({spheres}, {}, 2).writePgm(folder / "bar-right" / name);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("make_sample_data DIRECTORY\n", stderr);
    return 2;
  }
  const std::filesystem::path directory = argv[1];
  writeLogs(directory / "logs");
  writeEeg(directory / "eeg");
  writeExoskeleton(directory / "exoskeleton");
  writeBoards(directory / "boards");
  return 0;
}
