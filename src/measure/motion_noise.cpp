#include "simgap/measure/motion_noise.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kSmallestAngle =
    0.02 * kDegree;                        // noise of a good encoder or camera [rad], of a slide as JointKind::counted
constexpr double kSmallestCurrent = 2e-3;  // [A]

/// Sizes of the fourth differences of a channel's numbers.
void addFourthDifferences(const std::vector<double>& x, std::vector<double>& sizes) {
  for (std::size_t i = 4; i < x.size(); ++i) {
    sizes.push_back(std::abs(x[i] - 4.0 * x[i - 1] + 6.0 * x[i - 2] - 4.0 * x[i - 3] + x[i - 4]));
  }
}

/// White noise of standard deviation s leaves fourth differences of s sqrt(70); the median of |N(0, 1)| is 0.6745.
double noiseOf(std::vector<double> sizes, double smallest) {
  if (sizes.empty()) return smallest;
  return std::max(smallest, upperMedian(sizes) / (0.6745 * std::sqrt(70.0)));
}

/// The components of a joint over the frames, continuous.
std::vector<std::vector<double>> components(const RecordedMotion& motion, std::size_t joint, JointType type) {
  std::vector<std::vector<double>> ways(static_cast<std::size_t>(kindOf(type).degrees_of_freedom));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t f = 0; f < motion.joints.size(); ++f) {
    if (f > 0) sum += kindOf(type).difference(motion.joints[f - 1][joint], motion.joints[f][joint]);
    for (std::size_t c = 0; c < ways.size(); ++c) ways[c].push_back(sum[c]);
  }
  return ways;
}

}  // namespace

MotionNoise estimateNoise(std::span<const RecordedMotion> motions, const PoseLayout& layout, const KnownNoise& known) {
  MotionNoise noise;
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    std::vector<double> sizes;
    for (const RecordedMotion& motion : motions) {
      for (const std::vector<double>& way : components(motion, j, layout.joints[j].type)) {
        addFourthDifferences(way, sizes);
      }
    }
    const JointKind& kind = kindOf(layout.joints[j].type);
    const std::optional<double>& stated = kind.slides ? known.slides : known.joints;
    noise.joints.push_back(stated.value_or(noiseOf(std::move(sizes), kSmallestAngle / kind.counted)));
  }
  std::vector<double> shafts, currents;
  for (const RecordedMotion& motion : motions) {
    for (const MuscleRecord& muscle : motion.muscles) {
      addFourthDifferences(muscle.shafts, shafts);
      addFourthDifferences(muscle.currents, currents);
    }
  }
  noise.shafts = known.shafts.value_or(noiseOf(std::move(shafts), kSmallestAngle));
  noise.currents = known.currents.value_or(noiseOf(std::move(currents), kSmallestCurrent));
  return noise;
}

}  // namespace simgap
