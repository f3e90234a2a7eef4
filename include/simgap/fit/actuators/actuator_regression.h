/// \file
/// An actuator's log explained by a friction law, or another equation, and any number of effects
/// (simgap/model/effects/actuator_effect.h):
///
///     effort = saturated(P),    P = X(p) c / gain, delayed
///
/// Parameters, in order: c, the coefficients of the columns (of a law the first is 1 / k_a, torques enter as
/// theta / k_a), then p: v_s and delta of the law, the presliding of every real drive as a nuisance, the angle
/// offset of the rig's pendulum where it is fitted, and the effects' own.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "simgap/measure/logs/prepared_log.h"
#include "simgap/model/actuator/actuator_equation.h"
#include "simgap/model/effects/extension.h"
#include "simgap/optimize/row_fit.h"

namespace simgap {

inline constexpr std::string_view kAngleOffset = "angle_offset";

class ActuatorRegression : public RowModel {
 public:
  /// What `base` names, `effects` and `data` must outlive it. \param presliding  largest x_s of the nuisance [rad];
  /// none without.
  ActuatorRegression(const ActuatorBase& base, std::vector<const ActuatorEffect*> effects, const ActuatorData& data,
                     std::optional<double> presliding);

  /// The same model, with the same bounds, of other rows, which must outlive it. The nuisance stays where it is: it is
  /// seen in the first rows after a turn alone, of which others hold few.
  ActuatorRegression on(const ActuatorData& rows) const;

  const std::vector<ParameterSpec>& parameters() const override { return parameters_; }
  Eigen::Index rows() const override { return data_->rows.rows(); }
  void evaluate(std::span<const double> theta, Eigen::VectorXd& residual, Eigen::MatrixXd* jacobian) const override;

  const std::vector<const ActuatorEffect*>& effects() const { return effects_; }
  std::size_t linear() const { return linear_; }
  /// Index of the first of an effect's own p, and of its first column.
  std::size_t firstParameter(std::size_t effect) const { return p_begin_[effect]; }
  std::size_t firstColumn(std::size_t effect) const { return column_begin_[effect]; }

  /// A start for this model from one with other effects: what both have is taken over, the effects' p are neutral.
  std::vector<double> startFrom(const ActuatorRegression& other, std::span<const double> theta) const;
  /// The best coefficients for the p of theta on some blocks, within their bounds; p stays.
  /// \param cost  set to the sum of squares there, when it is wanted.
  std::vector<double> solveCoefficients(std::vector<double> theta, std::span<const Block> blocks,
                                        double* cost = nullptr) const;
  /// Coefficients and p by name, for values from a model file. \param physical  as physical() names them.
  std::vector<double> thetaOf(std::span<const Estimate> physical) const;
  /// The parameters behind theta: theta_i, theta_i / theta_0, or 1 / theta_0; those of an effect with its name before
  /// theirs ("coulomb-offset.n_c2"). \param covariance  of theta, shape (P, P)
  std::vector<Estimate> physical(std::span<const double> theta, const Eigen::MatrixXd& covariance) const;
  std::vector<Extension> extensions(std::span<const double> theta, const Eigen::MatrixXd& covariance) const;

  /// What the model predicts, shape (rows), also in rows that do not count.
  Eigen::ArrayXd predict(std::span<const double> theta) const;
  /// By how much the effort is logged later than the motion [s].
  double delay(std::span<const double> theta) const;
  /// Whether theta[parameter] makes some of it.
  bool isDelay(std::span<const double> theta, std::size_t parameter) const;

 private:
  struct Terms {
    ActuatorTerms shared;
    Eigen::ArrayXd stribeck;  ///< shape (rows): the Stribeck factor E, 0 for laws without one
    Eigen::ArrayXd weight;    ///< shape (rows): of a pendulum whose angle offset is fitted, or empty
  };
  /// Added columns of each effect, shape (rows, its columns); null: none, or not known.
  using Fills = std::vector<std::shared_ptr<const Eigen::ArrayXXd>>;
  struct Evaluation {
    Eigen::MatrixXd x;                  ///< shape (rows, C), delayed, over gain
    Terms terms;                        ///< with effects
    std::vector<ActuatorTerms> before;  ///< each effect that changes them; empty where no slopes are asked for
    Fills fills;
  };
  struct Shift {
    Eigen::Index whole;  ///< rows
    double part;         ///< of a row
  };
  /// Before effects act on them.
  /// \param stribeck  its factor where it is known at p; null: it is not
  Terms lawTerms(std::span<const double> p, const Eigen::ArrayXd* stribeck = nullptr) const;
  /// Where p[moved] is larger by a little than where the terms are `near`, to first order in the Stribeck factor.
  Terms lawTermsBeside(const Terms& near, std::span<const double> p, std::size_t moved, double by) const;
  /// \param effort  shape (rows): where the effort stands on the right.
  /// \param before  receives them as they are before each effect that changes them
  Terms withEffects(Terms law, std::span<const double> p, const Eigen::ArrayXd& effort,
                    std::vector<ActuatorTerms>* before = nullptr) const;
  void applyFrom(std::size_t first, std::span<const double> p, ActuatorTerms& terms,
                 std::vector<ActuatorTerms>* before = nullptr) const;
  Evaluation columns(Terms law, std::span<const double> p, bool slopes_too = false) const;
  /// As predict(theta), and by how much the effort is logged later than the motion [s]. \param law  lawTerms there
  Eigen::ArrayXd predict(const Terms& law, std::span<const double> theta, double& delay) const;
  /// As predict(theta), where theta[moved] is larger by `by` than where the columns are `e`: what that leaves as it is,
  /// is taken from there.
  Eigen::ArrayXd predictBeside(const Evaluation& e, const Terms& law, std::span<const double> theta, std::size_t moved,
                               double by) const;
  /// The equation's right-hand side, shape (rows). \param terms  with effects
  Eigen::ArrayXd rightHandSide(const Terms& terms, const Fills& fills, std::span<const double> theta) const;
  /// \param known  those that need not be filled again
  Fills fills(const Terms& terms, std::span<const double> p, Fills known = {}) const;
  /// Calls `visit(j, column)` for each column, over gain, not delayed.
  template <typename Visit>
  void visitColumns(const Terms& terms, const Fills& fills, const Visit& visit) const;
  /// The effect whose parameter that is.
  std::size_t effectOf(std::size_t parameter) const {
    return static_cast<std::size_t>(std::ranges::upper_bound(p_begin_, parameter) - p_begin_.begin()) - 1;
  }
  Shift shift(double delay) const;
  template <typename Array>
  void delayRows(Array& array, double delay) const;
  Eigen::Index source(Eigen::Index row, Eigen::Index by) const;
  std::vector<bool> counted(double delay) const;
  /// Rows that do not count become zeros, shape (rows, any).
  static void blank(Eigen::Ref<Eigen::MatrixXd> matrix, const std::vector<bool>& keep);
  std::span<const double> own(std::size_t effect, std::span<const double> p) const {
    return p.subspan(p_begin_[effect] - linear_, effects_[effect]->parameters.size());
  }
  void add(std::string name, std::string unit, double lower, double upper, bool fixed = false);
  void setRows(const ActuatorData& data);
  std::size_t afterStribeck() const { return linear_ + (base_.hasStribeck() ? 2 : 0); }

  ActuatorBase base_;
  std::vector<const ActuatorEffect*> effects_;
  const ActuatorData* data_;
  bool presliding_;
  bool implicit_ = false;  ///< the effort stands on the right-hand side as well, through the stretch of a tendon
  std::vector<ParameterSpec> parameters_;
  std::vector<bool> times_gain_;  ///< shape (C)
  std::size_t viscous_ = 0;       ///< column of the law's viscous friction, which a motor's back-EMF is a part of
  std::size_t linear_ = 0;
  std::vector<std::size_t> p_begin_, column_begin_;
  Eigen::ArrayXd log_speed_;                               ///< shape (rows)
  std::vector<Eigen::Index> session_begin_, session_end_;  ///< shape (rows): limits of the row's session
};

}  // namespace simgap
