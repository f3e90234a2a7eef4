/// \file
/// A friction law on a log as columns, residuals and derivatives.
#pragma once

#include <vector>

#include "simgap/fit/actuators/friction_fit.h"
#include "simgap/fit/actuators/stribeck_moments.h"

namespace simgap {

/// Parameters in order: k_a, the law's terms, the rig's constants, offset, v_s, delta. Linear columns in the same order
/// without the last two: the first carries the gain, 1 / k_a (or k_a, when the load is predicted). An angle of the rig
/// makes two columns, for A sin and A cos, even where A is known: the search relaxes that, the polish does not.
class FrictionModel {
 public:
  /// `law` and `data` must outlive it. \throws ConfigError: options that name unknown parameters.
  FrictionModel(const FrictionLaw& law, const FrictionData& data, const FrictionFitOptions& options);

  const FrictionLaw& law() const { return *law_; }
  const FrictionData& data() const { return *data_; }
  const std::vector<ParameterSpec>& parameters() const { return parameters_; }
  std::size_t freeCount() const;
  std::size_t speedIndex() const { return parameters_.size() - 2; }  ///< of v_s, for laws with a Stribeck term
  /// The scale of the load is known: only with it can k_a be told from the rig's constants.
  bool loadScaleKnown() const;
  bool loadDependsOnRig() const { return law_->needsLoad() && data_->load_per.cols() > 0; }

  /// \name The separable form.
  ///@{
  std::vector<FrictionShape> shapes() const;  ///< of the columns and, last, the target
  std::vector<LinearTerm> linearTerms() const;
  std::vector<NonlinearTerm> nonlinearTerms() const;
  Eigen::VectorXd initialRig() const;                          ///< coefficients of load_per, shape (K)
  Eigen::VectorXd rigOf(std::span<const double> theta) const;  ///< likewise
  /// Columns without their shapes and, last, the target, shape (rows, columns + 1); load-dependent ones at the load of
  /// `rig`.
  Eigen::ArrayXXd columns(const Eigen::VectorXd& rig, const Block& rows) const;
  /// Physical parameters of a separable solution.
  std::vector<double> thetaOf(const SeparableMinimum& minimum) const;
  ///@}

  /// The model must not move while the problem is in use: the problem holds copies of what it needs but the data.
  LeastSquaresProblem problem() const;

 private:
  void evaluate(std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                Eigen::Ref<Eigen::MatrixXd>* jacobian) const;
  /// A term's column without its shape. \param load  |load| of each row.
  Eigen::ArrayXd basis(const FrictionTerm& term, const Block& rows, const Eigen::ArrayXd& load) const;
  void addParameter(const FrictionFitOptions& options, ParameterSpec parameter);
  /// Of a known weight that hangs at an unknown angle, cosine and sine have the gain as their amplitude, which a search
  /// that is linear in both does not know: the gain that it found is that of the known inertia, and of nothing where
  /// another inertia is fitted beside it. \param coefficients  of the separable form
  Eigen::VectorXd gainFromWeight(Eigen::VectorXd coefficients) const;

  const FrictionLaw* law_;
  const FrictionData* data_;
  bool predict_load_;
  bool offset_;
  std::vector<ParameterSpec> parameters_;
  std::vector<double> fixed_;  ///< shape (P): values of the fixed ones
  std::size_t terms_;
  bool stribeck_;
  std::size_t rig_, rig_columns_, linear_;  ///< R, K, and k_a to offset
};

}  // namespace simgap
