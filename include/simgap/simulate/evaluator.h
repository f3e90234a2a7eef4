/// \file
/// Replays poses on many models at once: individuals x poses, in parallel, with the same result for any thread count.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "simgap/measure/pose_set.h"
#include "simgap/simulate/pose_protocol.h"

namespace simgap {

enum class AfterInvalid { kGoOn, kSkipRest };

/// Finds the steady state of poses; what searches for parameters knows nothing of how.
class Evaluator {
 public:
  virtual ~Evaluator() = default;
  /// \param after_invalid  kSkipRest: the poses behind an individual's first invalid one come back as kSkipped (001
  ///        aborts such an individual).
  /// \returns shape (models, poses), row by row. After an interrupt the rest is kSkipped; ask interruptRequested().
  virtual std::vector<PoseOutcome> evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                            AfterInvalid after_invalid) = 0;
};

/// The pose protocol on Bullet arms, one per thread.
/// \param threads  0: all the machine has.
std::unique_ptr<Evaluator> makeBulletEvaluator(const PoseProtocol& protocol, int threads);

/// Minima of the potential energy at the recorded shaft angles (EquilibriumArm::solve), without joint friction.
std::unique_ptr<Evaluator> makeEquilibriumEvaluator(int threads);

}  // namespace simgap
