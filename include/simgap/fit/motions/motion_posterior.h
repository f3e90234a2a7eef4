/// \file
/// What recorded motions, poses and hand measurements together say of an arm: the negative log posterior
///
///     1/2 sum_w rho(|e_w|^2) + 1/2 sum_p rho(d_p^2) + 1/2 |z|^2
///
/// e_w: whitened residual of a window of a motion (motion_residuals.h), p: poses as in PosePosterior, rho: as there.
/// z: the parameters in standard deviations of their prior, static and dynamic together, and behind them the delay of
/// the capture's clock. Derivatives are forward differences of whole rollouts, all parameters x motions in parallel.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "simgap/fit/motions/motion_residuals.h"
#include "simgap/fit/poses/pose_posterior.h"

namespace simgap {

using RowMajorF = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Residuals and derivatives of everything at one z.
struct MotionEvaluation {
  bool valid = false;
  double objective = 0.0;                  ///< infinite when not valid
  std::vector<Eigen::VectorXd> residuals;  ///< shape (motions) of (numbers)
  std::vector<PoseResidual> poses;         ///< shape (poses)
};

class MotionPosterior {
 public:
  struct Options {
    MotionOptions motion;
    KnownNoise noise;
    MotionDiscrepancy discrepancy;
    double capture_delay_sd = 0.05;     ///< prior of the capture's clock [s]; 0: it is known
    double capture_delay_farthest = 6;  ///< bound of it, in these standard deviations
    bool coarse_changes = false;        ///< derivatives from rollouts in steps twice as long (MotionOptions::coarser)
  };
  /// \param motions, poses  must outlive it; poses may be empty
  MotionPosterior(const ArmModel& model, std::span<const RecordedMotion> motions, std::span<const Pose> poses,
                  const std::vector<ParameterSpace::Choice>& parameters, const PoseNoise& pose_noise,
                  const Options& options);

  Eigen::Index size() const { return scaled_.size() + 1; }  ///< of z
  const ParameterSpace& space() const { return space_; }
  const ScaledParameters& parameters() const { return scaled_; }
  bool hasPrior(Eigen::Index i) const { return i == scaled_.size() || scaled_.hasPrior(i); }
  double lower(Eigen::Index i) const;  ///< of z: the parameter's, at most 6 standard deviations away
  double upper(Eigen::Index i) const;
  double captureDelay(const Eigen::VectorXd& z) const { return options_.capture_delay_sd * z[z.size() - 1]; }  ///< [s]
  ArmModel modelAt(const Eigen::VectorXd& z) const;
  const ArmModel& model() const { return model_; }
  const Options& options() const { return options_; }
  const std::vector<MotionResiduals>& motions() const { return motions_; }
  const MotionNoise& noise() const { return noise_; }

  /// All motions with the model at z, on the threads of all ranks (core/ranks.h), as are objectives() and jacobian().
  MotionEvaluation evaluate(const Eigen::VectorXd& z) const;
  /// The objective alone, of many z at once: models x motions in parallel. Infinite where a motion cannot be played.
  /// \param some  indices of the motions that count; empty: all
  std::vector<double> objectives(std::span<const Eigen::VectorXd> z, std::span<const std::size_t> some = {}) const;

  /// Residuals of motions with other models of this arm, shape (models)(motions)(numbers); empty where a motion cannot
  /// be played or is not among `some`. \param delays  of the capture's clock, shape (models) [s]
  /// \param some  indices of the motions to play; empty: all
  std::vector<std::vector<Eigen::VectorXd>> residualsOf(std::span<const ArmModel> models,
                                                        std::span<const double> delays,
                                                        std::span<const std::size_t> some = {}) const;

  /// What moves of z change in the residuals, shape (motions) of (numbers, moves), all moves x motions in parallel; NaN
  /// where a motion cannot be played. \param moves  shape (size(), moves)  \param progress  called with the number of
  /// rollouts done, of moves x motions
  std::vector<RowMajorF> changes(const Eigen::VectorXd& z, const Eigen::MatrixXd& moves, const MotionEvaluation& at,
                                 const std::function<void(std::size_t done)>& progress = {}) const;

  /// d residuals / d z of every motion, shape (motions) of (numbers, size()), by rollouts with each parameter moved by
  /// its step; 0 where that cannot be played; and of the poses, which go into `at.poses`.
  /// \param steps  shape (size()), in z, of either sign; 0: not asked, its derivatives are 0
  /// \param progress  as of changes()
  std::vector<RowMajorF> jacobian(const Eigen::VectorXd& z, const Eigen::VectorXd& steps, MotionEvaluation& at,
                                  const std::function<void(std::size_t done)>& progress = {}) const;

  /// Places drawn from a normal distribution, held within the bounds, the same for the same numbers.
  std::vector<Eigen::VectorXd> draws(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                                     std::uint32_t count) const;
  double objectiveOf(const MotionEvaluation& evaluation, const Eigen::VectorXd& z) const;
  /// Gradient and Gauss-Newton curvature with the prior's; a motion without derivatives (no rows) is left out.
  struct NormalEquations {
    Eigen::MatrixXd curvature;
    Eigen::VectorXd gradient;
  };
  NormalEquations normalEquations(const Eigen::VectorXd& z, const MotionEvaluation& at,
                                  std::span<const RowMajorF> jacobians) const;
  /// Robust weight of every number of a motion.
  Eigen::VectorXd weights(std::size_t motion, const Eigen::VectorXd& residuals) const;
  /// c of rho. A search that begins far off needs a wide one: windows beyond some c say nearly nothing of the way.
  void setRobustScale(double scale) { robust_scale_ = scale; }
  double robustScale() const { return robust_scale_; }
  /// Share of every motion that counts, from its beginning: what lies behind is not played. While a model is far off,
  /// errors pile up along a motion until its end may lie on the other side of a valley.
  void setHorizon(double share);
  bool counts(std::size_t motion, const ResidualBlock& block) const { return block.time <= until_[motion]; }

 private:
  struct Workers;
  Eigen::VectorXd residualsOf(const ArmModel& model, double delay, std::size_t motion, bool coarse = false) const;
  void playOne(const ArmModel& model, double delay, std::size_t motion, bool coarse, PlayedMotion& played) const;
  std::vector<PoseResidual> evaluatePoses(const Eigen::VectorXd& z, bool jacobians) const;
  double lossOf(std::size_t motion, const Eigen::VectorXd& residuals) const;  ///< sum of rho, times its weight

  ArmModel model_;
  ParameterSpace space_;
  ScaledParameters scaled_;
  Options options_;
  MotionNoise noise_;
  std::vector<MotionResiduals> motions_;
  std::vector<PlayableMotion> playable_;        ///< the same motions
  mutable std::optional<PosePosterior> poses_;  ///< each number that the parameters choose is one of its own there
  std::vector<std::size_t> owners_;             ///< the parameter it belongs to
  std::shared_ptr<Workers> workers_;
  double robust_scale_ = kRobustScale;
  std::vector<double> until_;  ///< of each motion, what counts [s]
};

}  // namespace simgap
