#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <optional>

#include "simgap/core/interrupt.h"
#include "simgap/simulate/evaluator.h"

namespace simgap {
namespace {

void lowerTo(std::atomic<std::size_t>& target, std::size_t value) {
  std::size_t seen = target.load();
  while (value < seen && !target.compare_exchange_weak(seen, value)) {
  }
}

class BulletEvaluator : public Evaluator {
 public:
  BulletEvaluator(const PoseProtocol& protocol, int threads)
      : protocol_(protocol), arena_(threads > 0 ? threads : tbb::task_arena::automatic) {}

  std::vector<PoseOutcome> evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                    AfterInvalid after_invalid) override {
    std::vector<PoseOutcome> outcomes(models.size() * poses.size());
    // A pose may be left out only because of an invalid one before it, so that the first invalid pose, which gives the
    // reason, is the same whatever the threads do.
    std::vector<std::atomic<std::size_t>> first_invalid(models.size());
    for (auto& first : first_invalid) first = poses.size();
    const auto replay = [&](std::size_t task) {
      const std::size_t k = task / poses.size();
      const std::size_t p = task % poses.size();
      if (interruptRequested() || first_invalid[k].load() < p) return;
      BulletArm& arm = armFor(models[k]);
      outcomes[task] = replayPose(arm, poses[p].shafts, protocol_);
      const bool invalid = outcomes[task].status != PoseStatus::kSteady;
      if (invalid && after_invalid == AfterInvalid::kSkipRest) lowerTo(first_invalid[k], p);
    };
    arena_.execute([&] { tbb::parallel_for(std::size_t{0}, outcomes.size(), replay, tbb::simple_partitioner()); });
    for (std::size_t task = 0; task < outcomes.size(); ++task) {
      if (task % poses.size() > first_invalid[task / poses.size()]) outcomes[task] = {};
    }
    return outcomes;
  }

 private:
  BulletArm& armFor(const ArmModel& model) {
    std::optional<BulletArm>& arm = arms_.local();
    if (arm) {
      arm->setModel(model);
    } else {
      arm.emplace(model, protocol_.arm);
    }
    return *arm;
  }

  PoseProtocol protocol_;
  tbb::task_arena arena_;
  tbb::enumerable_thread_specific<std::optional<BulletArm>> arms_;
};

}  // namespace

std::unique_ptr<Evaluator> makeBulletEvaluator(const PoseProtocol& protocol, int threads) {
  return std::make_unique<BulletEvaluator>(protocol, threads);
}

}  // namespace simgap
