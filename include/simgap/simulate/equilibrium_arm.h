/// \file
/// Where an arm comes to rest, without simulating the way there: the minimum of its potential energy that lies downhill
/// of where it starts. Joint friction, which can hold an arm beside that minimum, is left out.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <span>
#include <vector>

#include "simgap/simulate/arm_observation.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

/// How a search for an equilibrium ended.
struct EquilibriumSolution {
  bool stable = false;  ///< converged in a minimum; else it slides on, or rests on a saddle
  int doubts = 0;       ///< steps where the energy was not convex or a full step would have raised it
  int iterations = 0;   ///< evaluations of the energy
  double torque = 0.0;  ///< largest component of the gradient that no joint stop holds, at the last evaluation [N m]
};

/// The model, where all equilibria know it: they take a rope (Muscle::rope) for a straight line, which is good enough
/// to begin from, not to judge by. \throws ConfigError: a muscle is a rope
const ArmModel& withoutRopes(const ArmModel& model);

/// Damped Newton on SO(3)^n x R^m with joint limits as an active set; joints that follow others are eliminated. Memory
/// is taken in the constructor only.
class EquilibriumArm {
 public:
  explicit EquilibriumArm(const ArmModel& model);
  /// Another model of the same structure; the next pose starts from its rest.
  void setModel(const ArmModel& model);
  /// When the next pose was recorded; only extensions that need it take notice [s].
  void setHistory(double time, std::span<const double> shafts_before = {});

  /// The equilibrium that a slow movement of the shafts from 0 leads to (startPosition at shafts 0): straight from the
  /// rest, or by follow() where that leaves doubts. \param shafts  shape (model.commands())
  EquilibriumSolution solve(std::span<const double> shafts);
  /// The minimum downhill of a position. \param from  shape (joints), clamped to the joint limits
  /// \param max_iterations  evaluations of the energy; where they do not suffice, the solution is not stable
  EquilibriumSolution solveFrom(std::span<const JointPosition> from, std::span<const double> shafts,
                                int max_iterations = 100);
  /// Follows the equilibrium while the shafts move from 0 in proportion; steps shorten where it moves fast.
  /// Not stable when that takes more than some thousand evaluations, or the user asks to stop.
  EquilibriumSolution follow(std::span<const double> shafts);

  /// \name The last solution
  ///@{
  const std::vector<JointPosition>& joints() const { return joints_; }
  const PotentialEnergy& energy() const { return energy_; }
  bool atStop(int dof) const { return held_[dof]; }
  /// Evaluates the energy exactly at the solution (the search ends one step ahead of its last evaluation) and factors
  /// the Hessian without the joints at their stops; sensitivities need it.
  void linearise();
  /// H^-1 columns, rows of joints at their stops 0. After linearise(). \param[in,out] columns  shape (dof, any)
  void applyInverseHessian(Eigen::Ref<Eigen::MatrixXd> columns);
  /// dq/dp by the implicit function theorem, -H^-1 dG/dp, 0 for a joint at its stop. After linearise().
  /// \param[out] columns  shape (dof, parameters.size()) [rad per unit of the parameter]
  void sensitivities(std::span<const StaticParameter> parameters, Eigen::Ref<Eigen::MatrixXd> columns);
  /// Moves the solution to where a torque that friction holds, constant in the joints' frames, keeps the arm beside its
  /// equilibrium. \param torque  shape (dof) [N m] \returns false, and changes nothing, where there is no such place
  /// near
  bool hold(const Eigen::VectorXd& torque);
  /// The solution as a capture sees it: joints() unless the model's extensions say otherwise. With stiction joints()
  /// is then where that holds the arm.
  /// \param shafts_before  of the pose recorded before; may be empty
  const std::vector<JointPosition>& observe(std::span<const double> shafts, std::span<const double> shafts_before);
  /// Sensitivities of what observe() returned. After linearise().
  void observedSensitivities(std::span<const StaticParameter> parameters, Eigen::Ref<Eigen::MatrixXd> columns);
  ///@}

 private:
  /// A joint that follows another, by degrees of freedom.
  struct Coupling {
    int follower, leader;
    double ratio;
  };
  void findCouplings();
  void foldCouplings();
  EquilibriumSolution descend(int max_iterations);
  void evaluate() { energy_.evaluate(joints_); }
  double findHeld();
  double wayFrom(const std::vector<JointPosition>& position) const;  ///< largest joint rotation [rad]
  bool newtonStep();
  bool solveReduced();
  bool stopAtLimit();
  void applyStep(double scale);

  PotentialEnergy energy_;
  ArmObservation observation_;
  std::vector<JointPosition> joints_, observed_, start_, rest_, before_, reached_;
  bool rest_known_ = false;
  std::vector<double> shafts_;
  std::vector<char> held_;   ///< per dof: pressed against its stop
  std::vector<char> bound_;  ///< per dof: its step is given, by being held or by reaching a stop
  Eigen::VectorXd given_;    ///< that step
  Eigen::VectorXd torque_;   ///< that friction holds, 0 in an equilibrium
  Eigen::MatrixXd reduced_, inverse_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd step_, push_;
  std::vector<Coupling> couplings_;
};

/// All different equilibria found downhill of many starts (a fixed pattern over the joints' ranges), the given one
/// first. Costs some hundred solves.
std::vector<std::vector<JointPosition>> distinctEquilibria(EquilibriumArm& arm, std::span<const double> shafts,
                                                           std::span<const JointPosition> known);

}  // namespace simgap
