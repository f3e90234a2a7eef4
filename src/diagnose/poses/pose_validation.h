/// \file
/// How well a model predicts poses that took no part in its fit.
#pragma once

#include <span>
#include <vector>

#include "pose_fit.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Squared distances of poses from fits to the others.
struct CrossValidation {
  std::vector<double> distances;  ///< robust, shape (poses)
  double expected = 0.0;          ///< of their sum, were the model right
};

/// Five folds, interleaved in the order of recording.
class PoseFolds {
 public:
  explicit PoseFolds(std::span<const Pose> poses);
  /// \param z  where the fits of the folds begin \param like, z_like  the model that whitens
  CrossValidation validate(const PoseProblem& problem, const std::vector<ArmCause>& causes, const Eigen::VectorXd& z,
                           const std::vector<ArmCause>& like, const Eigen::VectorXd& z_like) const;

 private:
  struct Fold {
    std::vector<Pose> training, validation;
    std::vector<std::size_t> validation_index;
  };
  std::vector<Fold> folds_;
  std::size_t poses_;
};

}  // namespace simgap
