/// \file
/// Which poses to record next: of many possible commands those that, added to the recorded poses, leave the least
/// uncertainty, chosen one after the other (greedy).
#pragma once

#include <vector>

#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/pose_uncertainty.h"
#include "simgap/simulate/replay.h"

namespace simgap {

enum class DesignCriterion {
  kPrediction,   ///< I-optimal: mean standard deviation of the joints over the candidates, which stand for all poses
  kInformation,  ///< D-optimal: determinant of the parameters' covariance
};

struct DesignOptions {
  std::size_t candidates = 300;
  std::size_t poses = 7;  ///< to choose
  DesignCriterion criterion = DesignCriterion::kPrediction;
  std::uint64_t seed = 1;
};

struct PoseDesign {
  std::vector<Pose> poses;            ///< the chosen commands in their order, with the model's equilibria as joints
  PredictedError before;              ///< mean joint error predicted for unseen poses with the recorded poses alone
  std::vector<PredictedError> after;  ///< shape (poses): with the first 1, 2, … chosen poses added
  PredictedError after_random;        ///< with as many random candidates instead, for comparison
};

/// A design with what it was made from.
struct DesignResult {
  ArmModel model;  ///< fitted to the recorded poses
  PoseSet recorded;
  DesignOptions options;
  PoseDesign design;
  Assessment expected;  ///< the chosen poses in the model
};

/// \throws DataError: fewer than kFewestPoses.
void requireDesignable(const PoseSet& recorded);

/// Fits the arm to the recorded poses, which requireDesignable takes, and chooses the next ones.
/// \throws NumericsError: no fit, or as designPoses.
DesignResult designNextPoses(const ArmModel& model, const PoseSet& recorded, const CalibrationConfig& config,
                             const DesignOptions& options);

/// \param z  fitted to the posterior's poses
/// \throws NumericsError when too few candidates have a stable equilibrium.
PoseDesign designPoses(PosePosterior& posterior, const Eigen::VectorXd& z, const ParameterSpace& space,
                       const DesignOptions& options);

}  // namespace simgap
