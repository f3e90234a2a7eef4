#include "reality/capture_arm.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

namespace simgap::reality {
namespace {

double uniform(std::mt19937_64& engine, double lower, double upper) {
  return lower + (upper - lower) * (double(engine() >> 11) * 0x1.0p-53);
}

// The left camera stands 1.25 m in front of the torso (world -y) and 10 cm below the shoulder.
Eigen::Vector3d leftFromWorld(const Eigen::Vector3d& p) { return {p.x(), -p.z() - 0.1, p.y() + 1.25}; }

void writeText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

}  // namespace

std::vector<MarkerTarget> standardTargets() {
  return {{"torso", {{0, -0.16, 0.1}, {0.07, -0.18, 0.13}, {-0.05, -0.17, 0.17}, {0.03, -0.15, 0.21}}},
          {"humerus",
           {{0, -0.07, -0.1},
            {0.045, -0.075, -0.135},
            {-0.03, -0.07, -0.165},
            {0.015, -0.095, -0.21},
            {0.06, -0.06, -0.19}}},
          {"forearm", {{0, -0.06, -0.08}, {0.04, -0.065, -0.11}, {-0.035, -0.06, -0.15}, {0.01, -0.085, -0.2}}}};
}

std::vector<MarkerTarget> drawnTargets(std::uint64_t seed) {
  struct Place {
    const char* name;
    std::size_t markers;
    double near, far, low, high;  // y and z [m]
  };
  constexpr Place kPlaces[] = {{"torso", 4, -0.19, -0.15, 0.08, 0.22},
                               {"humerus", 5, -0.1, -0.06, -0.22, -0.1},
                               {"forearm", 4, -0.09, -0.055, -0.21, -0.08}};
  std::mt19937_64 engine(seed * 2 + 5);
  std::vector<MarkerTarget> targets;
  for (const Place& place : kPlaces) {
    MarkerTarget target{place.name, {}};
    std::vector<double> distances;
    while (target.markers.size() < place.markers) {
      const double x = uniform(engine, -0.06, 0.07);
      const double y = uniform(engine, place.near, place.far);
      const Eigen::Vector3d marker(x, y, uniform(engine, place.low, place.high));
      std::vector<double> all = distances;
      bool fits = true;
      for (const Eigen::Vector3d& other : target.markers) {
        const double distance = (marker - other).norm();
        fits = fits && distance > 0.035;
        for (const double known : all) fits = fits && std::abs(distance - known) > 4e-3;
        all.push_back(distance);
      }
      if (!fits) continue;
      target.markers.push_back(marker);
      distances = all;
    }
    targets.push_back(target);
  }
  return targets;
}

std::string targetsYaml(const std::vector<MarkerTarget>& targets, double radius) {
  std::ostringstream out;
  out.precision(17);
  out << "format: simgap/targets/1\nmarker_radius_m: " << radius << "\ntargets:\n";
  for (const MarkerTarget& target : targets) {
    out << "  - name: " << target.name << "\n    body: " << target.name << "\n    markers_m: [";
    for (std::size_t i = 0; i < target.markers.size(); ++i) {
      const Eigen::Vector3d& m = target.markers[i];
      out << (i ? ", " : "") << "[" << m.x() << ", " << m.y() << ", " << m.z() << "]";
    }
    out << "]\n";
  }
  return out.str();
}

ArmPose randomPose(std::uint64_t seed) {
  std::mt19937_64 engine(seed * 2 + 1);
  const double swing = uniform(engine, -0.5, 0.5);      // to the sides
  const double forward = uniform(engine, -0.35, 0.25);  // towards the cameras and back
  const double twist = uniform(engine, -0.4, 0.4);
  ArmPose pose;
  pose.shoulder = Eigen::AngleAxisd(swing, Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(forward, Eigen::Vector3d::UnitX()) *
                  Eigen::AngleAxisd(twist, Eigen::Vector3d::UnitZ());
  pose.elbow = uniform(engine, 0.45, 1.2);
  return pose;
}

ArmPose widePose(std::uint64_t seed) {
  std::mt19937_64 engine(seed * 2 + 2);
  ArmPose pose = randomPose(seed);
  pose.elbow = uniform(engine, 0.0, 1.6);
  return pose;
}

ArmPose between(const ArmPose& a, const ArmPose& b, double t) {
  return {a.shoulder.slerp(t, b.shoulder), a.elbow + t * (b.elbow - a.elbow)};
}

std::vector<std::vector<Eigen::Vector3d>> markersInLeft(const std::vector<MarkerTarget>& targets, const ArmPose& pose) {
  const Eigen::Vector3d elbow(0, 0, -0.28);
  const Eigen::AngleAxisd flexion(pose.elbow, Eigen::Vector3d::UnitX());
  std::vector<std::vector<Eigen::Vector3d>> all;
  for (const MarkerTarget& target : targets) {
    std::vector<Eigen::Vector3d>& points = all.emplace_back();
    for (Eigen::Vector3d p : target.markers) {
      if (target.name == "forearm") p = elbow + flexion * p;
      if (target.name != "torso") p = pose.shoulder * p;
      points.push_back(leftFromWorld(p));
    }
  }
  return all;
}

CaptureStage::CaptureStage(const StereoLenses& lenses, std::vector<MarkerTarget> targets, const Light& light,
                           double radius)
    : lenses_(lenses),
      targets_(std::move(targets)),
      radius_(radius),
      left_(lenses.left, light),
      right_(lenses.right, light) {}

RenderedPair CaptureStage::render(const std::vector<ArmPose>& poses, const Disturbance& disturbance,
                                  std::uint64_t seed) const {
  std::mt19937_64 engine(seed);
  RenderedPair pair;
  pair.markers = markersInLeft(targets_, poses[poses.size() / 2]);
  for (const auto& points : pair.markers) {
    std::vector<bool>& visible = pair.visible.emplace_back();
    for (std::size_t i = 0; i < points.size(); ++i) visible.push_back(uniform(engine, 0, 1) >= disturbance.occluded);
  }
  const std::size_t blocked = std::size_t(uniform(engine, 0.0, double(pair.markers.size())));
  std::vector<std::vector<Sphere>> left, right;
  for (const ArmPose& pose : poses) {
    const auto markers = markersInLeft(targets_, pose);
    std::vector<Sphere> spheres;
    for (std::size_t t = 0; t < markers.size(); ++t) {
      for (std::size_t i = 0; i < markers[t].size(); ++i) {
        if (pair.visible[t][i]) spheres.push_back({markers[t][i], radius_, 1.0});
      }
    }
    if (disturbance.blocker > 0.0) {
      const Eigen::Vector3d at = markers[blocked][0];
      spheres.push_back(
          {at * (1.0 - 0.05 / at.norm()) + Eigen::Vector3d(disturbance.blocker, 0, 0), disturbance.blocker, 0.0});
    }
    left.push_back(spheres);
    for (Sphere& sphere : spheres) sphere.centre = lenses_.rotation * sphere.centre + lenses_.translation;
    right.push_back(spheres);
  }
  std::vector<Spot> spots[2];
  for (int side = 0; side < 2; ++side) {
    const Lens& lens = side == 0 ? lenses_.left : lenses_.right;
    const double scale = lens.width / 640.0;
    for (int g = 0; g < disturbance.ghosts; ++g) {
      const double x = uniform(engine, 0, lens.width);
      const double y = uniform(engine, 0, lens.height);
      const double sigma = uniform(engine, 0.8, 3.0) * scale;
      spots[side].push_back({{x, y}, sigma, uniform(engine, 60, 260)});
    }
    if (disturbance.glare) spots[side].push_back({{0.85 * lens.width, 0.15 * lens.height}, 14 * scale, 2000});
  }
  pair.left = left_.render(left, spots[0], engine());
  pair.right = right_.render(right, spots[1], engine());
  return pair;
}

void CaptureStage::writeRig(const std::filesystem::path& folder) const {
  std::ostringstream rig;
  rig.precision(17);
  rig << "format: simgap/rig/1\nstereo: stereo.yaml\ntargets: targets.yaml\nscale_bar: {from: [torso, 0], to: [torso, "
         "3], length_m: "
      << (targets_[0].markers[0] - targets_[0].markers[3]).norm() << "}\n";
  writeText(folder / "rig.yaml", rig.str());
  writeText(folder / "stereo.yaml", stereoYaml(lenses_));
  writeText(folder / "targets.yaml", targetsYaml(targets_, radius_));
}

}  // namespace simgap::reality
