#include "simgap/fit/motions/motion_residuals.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr double kCorrelation = 0.3;  // [s], of the discrepancy

}  // namespace

MotionResiduals::MotionResiduals(const RecordedMotion& motion, const PoseLayout& layout, const MotionNoise& noise,
                                 const MotionDiscrepancy& discrepancy)
    : motion_(&motion) {
  using enum ChannelGroup;
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    types_.push_back(layout.joints[j].type);
    const JointKind& kind = kindOf(types_.back());
    addBlocks(kJoint, j, motion.joint_times, kind.degrees_of_freedom, noise.joints[j],
              kind.slides ? discrepancy.slides : discrepancy.joints);
  }
  for (std::size_t m = 0; m < motion.muscles.size(); ++m) {
    const MuscleRecord& muscle = motion.muscles[m];
    if (!muscle.shafts.empty()) addBlocks(kShaft, m, motion.times(), 1, noise.shafts, discrepancy.shafts);
    if (!muscle.currents.empty()) addBlocks(kCurrent, m, motion.times(), 1, noise.currents, discrepancy.currents);
  }
}

void MotionResiduals::addBlocks(ChannelGroup group, std::size_t item, const std::vector<double>& times,
                                Eigen::Index size, double noise, double discrepancy) {
  const double lasting = discrepancy * discrepancy * kCorrelation / kWindow;
  const auto first = std::ranges::lower_bound(times, motion_->compared_from) - times.begin();
  for (auto begin = static_cast<std::size_t>(first); begin < times.size();) {
    std::size_t end = begin + 1;
    while (end < times.size() && times[end] < times[begin] + kWindow * (1.0 - 1e-6)) ++end;
    const double of_noise = noise * noise / static_cast<double>(end - begin), variance = of_noise + lasting;
    blocks_.push_back({group, item, 0.5 * (times[begin] + times[end - 1]), size_, size, begin, end, std::sqrt(variance),
                       of_noise / variance});
    size_ += size;
    begin = end;
  }
}

double MotionResiduals::timeAt(double share) const {
  if (blocks_.empty()) return motion_->times().back();
  const auto [first, last] = std::ranges::minmax(blocks_, {}, &ResidualBlock::time);
  return share < 1.0 ? std::lerp(first.time, last.time, share) : last.time;
}

void MotionResiduals::evaluate(const PlayedMotion& played, Eigen::Ref<Eigen::VectorXd> residuals) const {
  const std::size_t joints = types_.size();
  const std::size_t rows = static_cast<std::size_t>(played.shafts.cols()), frames = played.joints.size() / joints;
  for (const ResidualBlock& block : blocks_) {
    if (block.end > (block.group == ChannelGroup::kJoint ? frames : rows)) {
      residuals.segment(block.first, block.size).setZero();
      continue;
    }
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const auto muscle = static_cast<Eigen::Index>(block.item);
    for (std::size_t i = block.begin; i < block.end; ++i) {
      switch (block.group) {
        case ChannelGroup::kJoint:
          sum += kindOf(types_[block.item])
                     .difference(motion_->joints[i][block.item], played.joints[i * joints + block.item]);
          break;
        case ChannelGroup::kShaft:
          sum[0] += played.shafts(muscle, static_cast<Eigen::Index>(i)) - motion_->muscles[block.item].shafts[i];
          break;
        case ChannelGroup::kCurrent:
          sum[0] += played.currents(muscle, static_cast<Eigen::Index>(i)) - motion_->muscles[block.item].currents[i];
          break;
      }
    }
    const double samples = static_cast<double>(block.end - block.begin);
    residuals.segment(block.first, block.size) = sum.head(block.size) / (samples * block.sd);
  }
}

}  // namespace simgap
