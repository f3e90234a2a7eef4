#include "parallel_evaluator.h"

namespace simgap {
namespace {

struct BulletReplay {
  using Arm = BulletArm;
  PoseProtocol protocol;
  Arm makeArm(const ArmModel& model) const { return Arm(model, protocol.arm); }
  PoseOutcome operator()(Arm& arm, const Pose& pose) const {
    arm.setHistory(pose.time, pose.shafts_before);
    return replayPose(arm, pose.shafts, protocol);
  }
};

}  // namespace

std::unique_ptr<Evaluator> makeBulletEvaluator(const PoseProtocol& protocol, int threads) {
  return std::make_unique<ParallelEvaluator<BulletReplay>>(BulletReplay{protocol}, threads, PosesAtOnce{1, 1});
}

}  // namespace simgap
