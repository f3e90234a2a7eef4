// Shaft angles that belong to the arm in the images of data/capture, from the statics of tests/reality:
//   make_capture_shafts data/capture [SEED] > shafts.csv
// The arm is one of those that data/arm/arm.yaml could be the hand measurement of (reality::makeRig). In every rest of
// truth.csv it is in equilibrium with all cords taut; between rests the shafts move as its elbow does.
#include <Eigen/Dense>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "reality/arm_rig.h"
#include "simgap/core/csv.h"

namespace {

using namespace simgap::reality;

constexpr double kTaut = 0.03;        // [m] that every cord is stretched before torques are balanced
constexpr double kLeastTaut = 0.002;  // [m] that is left of it afterwards
constexpr double kMostStrain = 0.8;
constexpr int kRestFrames = 3;  // that a pose has to last to be a rest

Eigen::Vector3d inWorld(const Arm& arm, const Attachment& end, const Configuration& q) {
  Eigen::Vector3d point = end.point;
  for (int link = end.link; link != kTorso; link = arm.links[link].parent) {
    const Link& body = arm.links[link];
    const Eigen::Matrix3d turn = body.joint == Joint::kSpherical
                                     ? q[link].rotation
                                     : Eigen::AngleAxisd(q[link].angle, body.axis).toRotationMatrix();
    point = body.joint_in_parent + turn * (point - body.joint_in_child);
  }
  return point;
}

Eigen::VectorXd torqueAt(const Arm& arm, const std::vector<double>& shafts, const Configuration& q) {
  const JointTorques torques = jointTorque(arm, shafts, q);
  Eigen::VectorXd all(4);
  all << torques[0], torques[1];
  return all;
}

/// The shafts nearest to equal stretch that hold the arm there: torques are linear in them while all cords are taut.
std::vector<double> shaftsFor(const Arm& arm, const Configuration& q) {
  std::vector<double> shafts;
  for (const Muscle& muscle : arm.muscles) {
    const double length = (inWorld(arm, muscle.to, q) - inWorld(arm, muscle.from, q)).norm();
    shafts.push_back((kTaut - length + muscle.kite_line + muscle.cord_rest) / muscle.spindle_radius);
  }
  const Eigen::VectorXd missing = torqueAt(arm, shafts, q);
  Eigen::MatrixXd slope(missing.size(), std::ssize(shafts));
  for (std::size_t m = 0; m < shafts.size(); ++m) {
    std::vector<double> wound = shafts;
    wound[m] += 0.1;
    slope.col(m) = (torqueAt(arm, wound, q) - missing) / 0.1;
  }
  const Eigen::VectorXd change = slope.transpose() * (slope * slope.transpose()).ldlt().solve(-missing);
  for (std::size_t m = 0; m < shafts.size(); ++m) {
    const double stretch = kTaut + arm.muscles[m].spindle_radius * change[m];
    if (stretch < kLeastTaut) throw std::runtime_error("a cord would be slack");
    shafts[m] += change[m];
  }
  const Equilibrium rest = minimise(arm, shafts, q);
  const double off = (rest.configuration[0].rotation - q[0].rotation).norm();
  if (!rest.converged || rest.stiffness <= 0.0 || off > 1e-6) throw std::runtime_error("no stable equilibrium there");
  if (largestStrain(arm, shafts, q) > kMostStrain) throw std::runtime_error("a cord would be stretched too far");
  return shafts;
}

std::vector<Configuration> readPoses(const std::string& file) {
  const simgap::CsvTable table = simgap::CsvTable::load(file);
  std::vector<Configuration> poses(table.rows(), Configuration(2));
  std::vector<std::vector<double>> q;
  for (const char* part : {"w", "x", "y", "z"}) q.push_back(table.quantity(std::string("shoulder_q") + part, ""));
  const std::vector<double> elbow = table.quantity("elbow", "rad");
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i][0].rotation = Eigen::Quaterniond(q[0][i], q[1][i], q[2][i], q[3][i]).normalized().toRotationMatrix();
    poses[i][1].angle = elbow[i];
  }
  return poses;
}

/// First and last frame of every rest.
std::vector<std::pair<std::size_t, std::size_t>> restsOf(const std::vector<Configuration>& poses) {
  std::vector<std::pair<std::size_t, std::size_t>> rests;
  for (std::size_t first = 0, i = 1; i <= poses.size(); ++i) {
    if (i < poses.size() && poses[i][1].angle == poses[first][1].angle) continue;
    if (i - first >= kRestFrames) rests.emplace_back(first, i - 1);
    first = i;
  }
  return rests;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : "data/capture";
  const Arm arm =
      makeRig(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 5, {.calibration = 0, .validation = 0}).truth;
  const std::vector<Configuration> poses = readPoses(folder + "/truth.csv");
  const std::vector<double> time = simgap::CsvTable::load(folder + "/truth.csv").quantity("time", "s");
  const auto rests = restsOf(poses);
  std::vector<std::vector<double>> shafts(poses.size());
  for (std::size_t r = 0; r < rests.size(); ++r) {
    const auto [first, last] = rests[r];
    for (std::size_t i = first; i <= last; ++i) shafts[i] = shaftsFor(arm, poses[first]);
    if (r == 0) continue;
    const std::size_t left = rests[r - 1].second;
    const double way = poses[first][1].angle - poses[left][1].angle;
    for (std::size_t i = left + 1; i < first; ++i) {
      const double share = (poses[i][1].angle - poses[left][1].angle) / way;
      for (std::size_t m = 0; m < arm.muscles.size(); ++m) {
        shafts[i].push_back(shafts[left][m] + share * (shafts[first][m] - shafts[left][m]));
      }
    }
  }
  std::printf("time_s");
  // In the order of data/arm/arm.yaml, which makeRig() draws from.
  for (const char* muscle :
       {"deltoid_anterior", "deltoid_lateral", "deltoid_posterior", "pectoralis_major", "latissimus_dorsi",
        "infraspinatus", "supraspinatus", "subscapularis", "biceps", "brachialis", "triceps"}) {
    std::printf(",shaft_%s_rad", muscle);
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::printf("\n%.6f", time[i]);
    for (const double shaft : shafts[i]) std::printf(",%.6f", shaft);
  }
  std::printf("\n");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
