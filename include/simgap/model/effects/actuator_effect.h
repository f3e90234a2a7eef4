/// \file
/// A physical cause that an actuator's model may lack: one file in src/model/effects/{drive,gearbox,motor,pam,spring},
/// found by CMake (docs/effects.md). The model of an actuator's effort is linear in all but a few numbers p:
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
#include <string>
#include <string_view>
#include <vector>

#include "simgap/measure/logs/actuator_rows.h"

namespace simgap {

struct FrictionLaw;

/// What a motor draws that would draw I if its torque grew with its current for ever, in
/// effort = I / (1 - sag sign(I) (I - I_v)) + cubic I^3 + excess sign(I) max(|I| - knee, 0), I_v the part of I for the
/// speed.
struct Saturation {
  double sag = 0.0;     ///< [1/A] of a supply: the share of the effort that its resistance takes goes with I - I_v
  double cubic = 0.0;   ///< [1/A^2]
  double excess = 0.0;  ///< [1]
  double knee = 0.0;    ///< [A]

  bool acts() const { return sag != 0.0 || cubic != 0.0 || excess != 0.0; }
  /// \param i, i_v  shape (n)
  Eigen::ArrayXd effort(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const;
  /// Of the effort by I, I_v held.
  Eigen::ArrayXd slope(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const;
  /// Of the effort by I_v, I held.
  Eigen::ArrayXd slopeBySpeed(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const;
};

/// What the columns are made of. Arrays of shape (n).
struct ActuatorTerms {
  Eigen::ArrayXd load;         ///< [N m] what the drive works against
  Eigen::ArrayXd dry;          ///< what multiplies dry friction: direction x presliding x factors
  Eigen::ArrayXd viscous;      ///< [rad/s] what multiplies k_v
  Eigen::ArrayXd gain;         ///< torque per ampere, relative to k_a; empty: 1
  Saturation saturation;       ///< of the motor
  double delay = 0.0;          ///< [s] the effort is logged that much later than the motion
  Eigen::ArrayXd effort;       ///< [N] of a muscle: what stretches its tendon
  Eigen::ArrayXd pressure;     ///< [Pa] that drives a muscle
  Eigen::ArrayXd contraction;  ///< [1] of the muscle itself
  Eigen::ArrayXd deflection;   ///< [m] or [rad] by which a spring is stretched
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

/// A number that models of a kind hold as one of their own: who finds it there has the effect, whose only parameter it
/// stands for.
struct OwnParameter {
  std::string_view law;          ///< of models that have it
  std::string_view law_without;  ///< of those that have not
  std::string_view name;
  std::string_view unit;  ///< empty: as the effect's
  bool inverse = false;   ///< 1 / the effect's parameter

  double convert(double value) const { return inverse ? 1.0 / value : value; }  ///< to the effect's and from it
};

/// A named physical cause. Whoever needs to know something of an effect reads it here: nothing outside its file tests
/// an effect by its name, and docs/effects.md is written from these fields (tests/model/effects/effects_page_test.cpp).
struct ActuatorEffect {
  std::string_view name;                        ///< of the catalogue
  std::string_view form = {};                   ///< "linear": one of several laws of the same cause; empty: the only
  ActuatorKind kind = ActuatorKind::kFriction;  ///< which logs can show it (see appliesTo)
  std::string_view cause;                       ///< one sentence for people
  std::string_view equation;                    ///< one line
  std::string_view signature;                   ///< what the residual of a model without it looks like
  std::string_view remarks = {};                ///< what else to know of it; may be empty
  std::string_view source;                      ///< where it comes from
  std::string_view look_alikes;                 ///< what it is easily confused with
  std::string_view separates;                   ///< the log that tells it from them: continues "record …"
  std::span<const EffectParameter> parameters = {};  ///< shape (P)
  std::span<const EffectColumn> columns = {};        ///< shape (C)
  std::span<const OptionalChannel> needs = {};       ///< of a log
  /// The same cause by other laws. Which of them the data follow is a detail of the finding: they share a name.
  std::span<const ActuatorEffect* const> other_forms = {};
  /// True for laws of which it is a part already, or in which it has no meaning; none: it adds to every law.
  bool (*contained_in)(const FrictionLaw& law) = nullptr;
  bool needs_stribeck = false;  ///< it acts on the Stribeck term of a law
  bool is_offset = false;       ///< a constant effort: part of every fit with an offset of its own
  bool implicit = false;        ///< `apply` reads terms.effort: the effort stands on both sides of the equation
  /// A channel that it is a multiple of: where a fitted constant of the bench is one, too, they say the same.
  Eigen::ArrayXd ActuatorRows::*multiple_of = nullptr;
  bool is_bias = false;       ///< constant from the beginning on: what begins at a moment is no rival of it
  bool at_moment = false;     ///< from a moment on: more than a drift has to explain
  bool of_angle = false;      ///< an effort that goes with the joint's angle alone
  bool of_load_sign = false;  ///< it goes with the load's sign, whatever its size: of a load near zero noise decides it
  bool of_rows = false;       ///< `fill` looks at the rows and at its own parameters alone, and is worth keeping
  bool remembers = false;     ///< it depends on the rows before: on travel, rests, another time
  bool needs_all_rows = false;  ///< it looks at more than a row and the travel since the one before
  bool in_every_drive = false;  ///< models without it carry a little of it (kNuisance); it has one parameter
  bool on_drive = false;        ///< a gearbox's cause that any drive can have, too
  bool on_robot = false;        ///< a joint of a robot shows it: its log has the channels, and rests say nothing
  double places = 1.0;          ///< at which its shape is looked for; of more than one several can act at once
  /// Causes of one kin may change the rows alike, each by a law of its own: a small lead does not tell them.
  std::string_view kin = {};
  const OwnParameter* own_parameter = nullptr;
  bool on_gearbox = true;  ///< false: a gearbox's own causes say it in other words, or its rows cannot show it

  /// Changes the terms. \param p  shape (P), within the bounds.
  void (*apply)(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) = nullptr;
  /// Fills the added columns (signed as the friction they add). \param stribeck  shape (n): the Stribeck factor E,
  /// 0 for laws without one.  \param x  shape (n, C).
  void (*fill)(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
               const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) = nullptr;
  /// Where to search, shape (starts)(P); none: at `start` of every parameter. \param residual  shape (n) of the model
  /// without the effect.
  std::vector<std::vector<double>> (*starts)(const ActuatorRows& rows, const Eigen::ArrayXd& residual) = nullptr;
  /// False for values that are no finding: so small that sampling alone makes them, or beyond the log; none: all count.
  bool (*counts)(std::span<const double> p, const ActuatorRows& rows) = nullptr;
};

/// Parameter by which a model has a little of the effect that is in every drive.
inline constexpr std::string_view kNuisance = "presliding";

/// The usual form of a cause that has others, too.
constexpr ActuatorEffect withForms(ActuatorEffect usual, std::span<const ActuatorEffect* const> others) {
  usual.other_forms = others;
  return usual;
}

/// "bend-friction (linear)"
std::string titleOf(const ActuatorEffect& effect);

/// A gearbox has its own causes and those of any drive that are not ruled out (on_gearbox).
bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind);

namespace actuator_effects {
std::span<const ActuatorEffect* const> all();
/// \param form  of the effect; empty: its usual one
/// \throws ConfigError that lists the known effects, or the forms of this one.
const ActuatorEffect& find(std::string_view name, std::string_view form = {});
/// The one between the two angles of a drive.
const ActuatorEffect& ofTransmission();
/// The effect that every real drive has a little of.
const ActuatorEffect& inEveryDrive();
}  // namespace actuator_effects

}  // namespace simgap
