/// \file
/// The numbers of a model by name, and the choice of some of them by pattern (`muscles.*.attachments`).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/arm_sizes.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

/// Where a number stands in the model, as in its file with names for indices; joined only when somebody reads it.
struct ParameterPath {
  std::string_view group;   ///< "muscles", "tendons", "joints", "bodies", "extensions" or "gravity_m_s2"
  std::string_view item;    ///< name of the muscle, joint or body; of an extension "effect:target"
  std::string_view member;  ///< "shock_cord.stiffness_N_m"
  int component = -1;       ///< 0, 1, 2 for x, y, z of a vector
  std::string str() const;  ///< "muscles.biceps.attachments.0.point_m.x"
};

/// What a number of the model is, whatever its value.
struct ParameterKind {
  std::string_view unit;          ///< SI, as a suffix: "N_m"
  Range range;                    ///< what a model file may hold
  ArmSize size = ArmSize::kNone;  ///< of the arm that the range goes with
};

/// Calls `visit` with every number of the model that a calibration may change, in a fixed order.
using ParameterVisitor = std::function<void(const ParameterPath& path, const ParameterKind& kind, double& value)>;
void visitParameters(ArmModel& model, const ParameterVisitor& visit);

/// True when the pattern's dot-separated parts match the first parts of the path; `*` stands for any
/// text within a part (`muscles.l_*.spindle_radius_m`), alone for one part or several (`*.spindle_radius_m`).
bool matchesPattern(std::string_view pattern, std::string_view path);

/// One parameter that is searched. Its name is its path, its bounds the configuration's, or what the model file may
/// hold.
struct SearchParameter : ParameterSpec {
  double initial;                  ///< value in the model
  double step;                     ///< initial step size, > 0
  std::optional<double> prior_sd;  ///< how well the initial value is known, in the parameter's unit
};

/// A chosen subset of a model's numbers, in the order of visitParameters.
class ParameterSpace {
 public:
  /// One entry of a configuration's `parameters:` list.
  struct Choice {
    std::string pattern;
    double step;
    std::optional<double> lower, upper;
    std::optional<double> prior_sd;          ///< in the parameter's unit
    std::optional<double> prior_sd_percent;  ///< of the initial value
    bool together = false;  ///< all that match are one parameter and change in proportion; its name is the pattern
    std::string only = {};  ///< of what matches, what matches this too; empty: all
  };
  /// Reads the list; `{pattern, step, lower?, upper?, prior_sd?, prior_sd_percent?, together?, only?}`.
  static std::vector<Choice> readChoices(const YamlNode& list);

  /// \throws ConfigError: a pattern that matches nothing, a parameter matched twice, lower > upper, an initial value
  ///         outside its range.
  ParameterSpace(const ArmModel& model, const std::vector<Choice>& choices);

  const std::vector<SearchParameter>& parameters() const { return parameters_; }
  std::size_t size() const { return parameters_.size(); }
  /// The parameter that each chosen number belongs to, in the order of visitParameters; 0, 1, 2 … without `together`.
  std::vector<std::size_t> owners() const;

  /// Writes `values`, shape (size()), into the model the space was made from, or a copy of it.
  void apply(std::span<const double> values, ArmModel& model) const;
  /// What such a model holds of them, shape (size()).
  std::vector<double> values(ArmModel model) const;

 private:
  struct Number {
    std::size_t position;   ///< among all visited numbers, ascending
    std::size_t parameter;  ///< index
    double ratio;           ///< to the parameter's value
  };
  void forEachChosen(ArmModel& model, const std::function<void(const Number& number, double& value)>& action) const;

  std::vector<SearchParameter> parameters_;
  std::vector<Number> numbers_;
};

}  // namespace simgap
