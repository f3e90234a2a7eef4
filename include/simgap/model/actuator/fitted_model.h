/// \file
/// Fitted drive models as files: `format: simgap/friction/1` (likewise motor, gearbox, pam, spring): values with their
/// covariance, and the data they came from.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/effects/extension.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

/// Law of a spring that only pulls: no force below its `rest_length`.
inline constexpr char kCord[] = "cord";

struct FittedModel {
  std::string kind;                  ///< "friction", "motor", "gearbox", "pam", "spring"
  std::string law;                   ///< of a friction model; of a PAM "spring" or "no-spring"; of a spring kCord or ""
  std::vector<Estimate> parameters;  ///< shape (P)
  Eigen::MatrixXd covariance;        ///< shape (P, P); empty when unknown
  std::map<std::string, std::string> settings;  ///< how the model is meant: "effort", "predicts", "dead_band_rad_s" …
  std::string data_file, data_sha256;
  std::size_t data_rows = 0;
  std::vector<Extension> extensions;  ///< causes that were added to the law (simgap/model/effects/actuator_effect.h)
  std::string file = {};              ///< that it was read from, for errors; empty of a model that was just fitted

  bool has(std::string_view name) const;
  /// \throws ConfigError when the model has no such parameter.
  double value(std::string_view name) const;
  double valueOr(std::string_view name, double otherwise) const { return has(name) ? value(name) : otherwise; }
  std::string setting(const std::string& key, const std::string& otherwise = "") const;
};

/// What was estimated as a model; what could not be found is left out.
FittedModel fittedModel(const std::string& kind, const std::string& law, const Uncertainty& uncertainty);

std::string writeFittedModel(const FittedModel& model);

/// \throws ConfigError: another format, a kind that is none of `kinds` (any when empty), a covariance of the wrong
///         shape.
FittedModel readFittedModel(const YamlNode& root, const std::vector<std::string>& kinds = {});

}  // namespace simgap
