/// \file
/// An arm model with causes, fitted as a whole to some poses.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "diagnose/arm_cause.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/ranks.h"
#include "simgap/fit/poses/levenberg_marquardt.h"

namespace simgap {

/// What all fits of a diagnosis share.
struct PoseProblem {
  ArmModel nominal;
  std::vector<ParameterSpace::Choice> parameters;
  PoseNoise noise;
  int threads = 0;
  double stray_friction = 1.0;  ///< share of the joints' Coulomb friction that may hold them on any side
};

/// Calls action(i) for i = 0 ... count - 1 on the problem's threads; results go where i says.
template <class Action>
void forEach(const PoseProblem& problem, std::size_t count, const Action& action) {
  tbb::task_arena arena(problem.threads > 0 ? problem.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (!interruptRequested()) action(i);
    });
  });
  stopIfInterrupted();
}

/// place(i, compute(i)) likewise, on all ranks (core/ranks.h). \param z  that the tasks begin from
template <class Compute, class Place>
void forEachOnRanks(const PoseProblem& problem, std::size_t count, const Eigen::VectorXd& z, const Compute& compute,
                    const Place& place) {
  tbb::task_arena arena(problem.threads > 0 ? problem.threads : tbb::task_arena::automatic);
  using Result = std::decay_t<decltype(compute(std::size_t{0}))>;
  const auto unlessInterrupted = [&](std::size_t i) { return interruptRequested() ? Result() : compute(i); };
  Bytes digest;
  pack(digest, z);
  arena.execute([&] { shareOnRanks(count, unlessInterrupted, place, /*one_by_one=*/false, std::move(digest)); });
  stopIfInterrupted();
}

class PoseFit {
 public:
  /// \param poses  must outlive it.
  PoseFit(const PoseProblem& problem, std::span<const Pose> poses, std::vector<ArmCause> causes);

  const std::vector<ArmCause>& causes() const { return causes_; }
  const ParameterSpace& space() const { return space_; }
  PosePosterior& posterior() { return posterior_; }
  const Eigen::VectorXd& z() const { return z_; }
  double objective() const { return objective_; }
  std::size_t ordinary() const { return ordinary_; }  ///< parameters before those of the causes

  /// Where a fit with these causes begins when one of less causes ended at z.
  Eigen::VectorXd extended(const Eigen::VectorXd& z) const;
  /// The solution without the parameters of one cause.
  Eigen::VectorXd solutionWithout(std::size_t cause) const;
  void descend(const Eigen::VectorXd& z, double tolerance = 1e-7);
  /// The best of several starts, whitened with its own solution. \returns whether every pose found an equilibrium
  bool search(int starts, int threads, std::uint64_t seed);
  /// Poses without an equilibrium where all torques are balanced best, shape (poses).
  std::vector<bool> withoutEquilibrium();
  void setSolution(const Eigen::VectorXd& z) { z_ = z; }

  /// Residuals at the solution, with Jacobians.
  const std::vector<PoseResidual>& linearised() { return posterior_.evaluate(z_, true); }
  /// Gauss-Newton curvature at the solution, priors included, shape (parameters, parameters).
  Eigen::MatrixXd curvature();
  Eigen::VectorXd gradient();  ///< of the objective at the solution, shape (parameters)
  /// Log of the posterior's integral (Laplace), up to a constant that all fits to the same poses share.
  double logEvidence();
  ArmModel model() const;
  /// The causes with their fitted values and standard deviations.
  std::vector<Extension> extensions();

 private:
  void followKinks();

  ArmModel prior_;  ///< the nominal model with the causes at their expected values
  std::vector<Joint> nominal_joints_;
  std::vector<ArmCause> causes_;
  ParameterSpace space_;
  PosePosterior posterior_;
  std::size_t ordinary_;
  Eigen::VectorXd z_;
  double objective_ = 0.0;
};

/// A fit to poses, whitened at z and descended from there. \param poses  must outlive it \param z  of the model with
/// all causes, or with the first of them
PoseFit fittedFrom(const PoseProblem& problem, std::span<const Pose> poses, const std::vector<ArmCause>& causes,
                   const Eigen::VectorXd& z);

/// d_p^2 of poses that took no part in the fit, whitened as `like` (of the same poses); capped where there is no
/// equilibrium.
std::vector<double> unseenDistances(const PoseFit& fit, const PoseProblem& problem, std::span<const Pose> poses,
                                    const PoseFit& whitening_from);

}  // namespace simgap
