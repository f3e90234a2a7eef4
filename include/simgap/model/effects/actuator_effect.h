/// \file
/// A physical cause that an actuator's model may lack: one file in src/model/effects/{drive,gearbox,motor,pam}, found
/// by CMake (docs/effects.md). The model of an actuator's effort is linear in all but a few numbers p:
///
///     effort = X(p) c,   X = [load | friction law's columns | effects' columns | 1] / gain
///
/// or, for what is no drive with friction, X = [equation's columns | effects' columns]
/// (simgap/model/actuator/actuator_equation.h). An effect changes the terms the columns are made of (a factor on dry
/// friction, another load …), adds columns, or both; none knows of the others. Efforts are the motor's, torques those
/// the load is measured in; speed and acceleration are the motor's.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "simgap/measure/logs/actuator_rows.h"

namespace simgap {

/// What the columns are made of. Arrays of shape (n).
struct ActuatorTerms {
  Eigen::ArrayXd load;         ///< [N m] what the drive works against
  Eigen::ArrayXd dry;          ///< what multiplies dry friction: direction x presliding x factors
  Eigen::ArrayXd viscous;      ///< [rad/s] what multiplies k_v
  Eigen::ArrayXd gain;         ///< torque per ampere, relative to k_a; empty: 1
  double cubic = 0.0;          ///< [1/A^2] effort = I + cubic I^3
  double delay = 0.0;          ///< [s] the effort is logged that much later than the motion
  Eigen::ArrayXd effort;       ///< [N] of a muscle: what stretches its tendon
  Eigen::ArrayXd pressure;     ///< [Pa] that drives a muscle
  Eigen::ArrayXd contraction;  ///< [1] of the muscle itself
};

/// A number that enters the model non-linearly.
struct EffectParameter {
  std::string_view name;
  std::string_view unit;  ///< SI suffix; "1" when dimensionless
  double lower, upper;    ///< every value between is a valid model
  double neutral;         ///< without the effect
  double start;           ///< where a search begins, besides `starts`
  enum class Kind {
    kSmooth,    ///< how much of the effect there is
    kShape,     ///< where it acts, how fast …: has no neutral value
    kScanned,   ///< kShape without a derivative
    kConstant,  ///< a reference value, not fitted
  } kind = Kind::kSmooth;
};

/// A coefficient that enters linearly.
struct EffectColumn {
  std::string_view name;
  std::string_view unit;  ///< "Nm" stands for the load's, "A" for the effort's unit
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool torque = true;  ///< false: adds to the effort itself
};

struct ActuatorEffect {
  std::string_view name;                             ///< of the catalogue
  ActuatorKind kind = ActuatorKind::kFriction;       ///< which logs can show it (see appliesTo)
  std::string_view cause;                            ///< one sentence for people
  std::string_view equation;                         ///< one line
  std::string_view source;                           ///< where it comes from
  std::string_view look_alikes;                      ///< what it is easily confused with
  std::string_view separates;                        ///< the log that tells it from them: continues "record …"
  std::span<const EffectParameter> parameters = {};  ///< shape (P)
  std::span<const EffectColumn> columns = {};        ///< shape (C)
  std::span<const OptionalChannel> needs = {};

  /// Changes the terms. \param p  shape (P), within the bounds.
  void (*apply)(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) = nullptr;
  /// Fills the added columns (signed as the friction they add). \param still  shape (n): E of the Stribeck term, 0 for
  /// laws without one.  \param x  shape (n, C).
  void (*fill)(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
               const Eigen::ArrayXd& still, Eigen::Ref<Eigen::ArrayXXd> x) = nullptr;
  /// Where to search, shape (starts)(P); none: at `start` of every parameter. \param residual  shape (n) of the model
  /// without the effect.
  std::vector<std::vector<double>> (*starts)(const ActuatorRows& rows, const Eigen::ArrayXd& residual) = nullptr;
  /// False for values so small that sampling alone makes them; none: every value counts.
  bool (*counts)(std::span<const double> p, const ActuatorRows& rows) = nullptr;
};

/// A gearbox has its own causes and, but for those that say the same in other words, those of any drive.
bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind);

namespace actuator_effects {
std::span<const ActuatorEffect* const> all();
/// \throws ConfigError that lists the known effects.
const ActuatorEffect& find(std::string_view name);
}  // namespace actuator_effects

}  // namespace simgap
