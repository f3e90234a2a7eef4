#include "parallel_evaluator.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

struct EquilibriumReplay {
  using Arm = EquilibriumArm;
  Arm makeArm(const ArmModel& model) const { return Arm(withoutRopes(model)); }
  PoseOutcome operator()(Arm& arm, const Pose& pose) const {
    PoseOutcome outcome;
    arm.setHistory(pose.time, pose.shafts_before);
    const EquilibriumSolution solution = arm.solve(pose.shafts);
    if (!solution.stable) {
      outcome.status = PoseStatus::kNoEquilibrium;
      outcome.worst_value = solution.torque;
      return outcome;
    }
    outcome.status = PoseStatus::kSteady;
    outcome.joints = arm.observe(pose.shafts, pose.shafts_before);
    outcome.shafts = pose.shafts;
    const std::vector<Muscle>& muscles = arm.energy().model().muscles;
    for (std::size_t m = 0; m < muscles.size(); ++m) {
      outcome.cord_expansion.push_back(arm.energy().expansion(m) / muscles[m].shock_cord.rest_length);
    }
    return outcome;
  }
};

}  // namespace

std::unique_ptr<Evaluator> makeEquilibriumEvaluator(int threads) {
  constexpr PosesAtOnce kAtOnce{64, 2048};  // some 0.5 ms and 15 ms: far above what a task and a message cost
  return std::make_unique<ParallelEvaluator<EquilibriumReplay>>(EquilibriumReplay{}, threads, kAtOnce);
}

}  // namespace simgap
