/// \file
/// What a capture sees of an arm at rest: its equilibrium, held back by stiction, through markers that may be turned
/// against the bones. Without such extensions it is the equilibrium itself.
#pragma once

#include <span>
#include <vector>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

class EquilibriumArm;

class ArmObservation {
 public:
  explicit ArmObservation(const ArmModel& model) { setModel(model); }
  void setModel(const ArmModel& model);
  bool plain() const { return extensions_.empty(); }

  /// The joints as captured. Moves the arm to where stiction holds it. \param shafts_before  of the pose before; empty:
  /// unknown
  void observe(EquilibriumArm& arm, std::span<const double> shafts, std::span<const double> shafts_before,
               std::vector<JointPosition>& joints);
  /// Turns sensitivities of the equilibrium into those of what was last observed; how the direction of stiction depends
  /// on the parameters is left out. \param[in,out] columns  shape (dof, parameters.size())
  void chain(EquilibriumArm& arm, std::span<const StaticParameter> parameters,
             Eigen::Ref<Eigen::MatrixXd> columns) const;

  /// The turn of a body's markers, a rotation vector in its frame.
  Eigen::Vector3d markerTurn(int body) const;
  /// Joints of bones as the capture sees them. \param[in,out] joints  shape (joints)
  void turnMarkers(std::vector<JointPosition>& joints) const;

 private:
  Eigen::VectorXd findSides(EquilibriumArm& arm, std::span<const double> shafts, std::span<const double> shafts_before);
  struct Kept {
    int index;  ///< among the model's extensions
    ArmExtension extension;
  };
  std::vector<Joint> joints_;
  std::vector<Kept> extensions_;        ///< those with a marker_turn or stiction
  std::vector<Eigen::VectorXd> sides_;  ///< per entry: unit torque of what stiction holds, shape (dof)
  std::vector<JointPosition> bones_;    ///< before the markers
  bool markers_ = false, sticks_ = false;
};

}  // namespace simgap
