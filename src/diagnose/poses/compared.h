/// \file
/// One cause more or not: what the poses say of each.
#pragma once

#include <cmath>

#include "pose_fit.h"
#include "pose_selection.h"

namespace simgap {

/// Models with one cause more, against one without it.
class Compared {
 public:
  explicit Compared(PoseFit& without) : evidence_(without.logEvidence()), objective_(without.objective()) {}

  /// The solution, and behind it log evidence and objective: what goes from rank to rank.
  static Eigen::VectorXd pack(PoseFit& fit) {
    Eigen::VectorXd packed(fit.z().size() + 2);
    packed << fit.z(), fit.logEvidence(), fit.objective();
    return packed;
  }
  PoseCandidate candidate(const ArmCause& cause, const Eigen::VectorXd& packed, double share) const {
    const Eigen::Index n = packed.size() - 2;
    return {cause, packed.head(n), packed[n] - evidence_ + std::log(share), objective_ - packed[n + 1], share};
  }

 private:
  double evidence_, objective_;
};

}  // namespace simgap
