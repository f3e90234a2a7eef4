#include "simgap/model/friction/friction_evaluation.h"

#include <cmath>

namespace simgap {
namespace {

std::string unitOfTerm(FrictionBasis basis, std::string_view load_unit) {
  switch (basis) {
    case FrictionBasis::kLoad:
      return "1";
    case FrictionBasis::kDirection:
      return std::string(load_unit);
    case FrictionBasis::kVelocity:
      return load_unit == "N" ? "Ns_m" : "Nms_rad";
  }
  return "1";
}

}  // namespace

std::vector<ParameterSpec> termParameters(const FrictionLaw& law, std::string_view load_unit) {
  std::vector<ParameterSpec> parameters;
  for (const FrictionTerm& term : law.terms) {
    parameters.push_back({.name = std::string(term.name), .unit = unitOfTerm(term.basis, load_unit), .lower = 0.0});
  }
  return parameters;
}

std::string gainUnit(const std::string& load_unit, const std::string& effort_unit) {
  return load_unit == effort_unit ? "1" : load_unit + "_" + effort_unit;
}

std::vector<ParameterSpec> stribeckParameters(const FrictionLaw& law, double top_speed,
                                              std::string_view velocity_unit) {
  if (!law.hasStribeck()) return {};
  return {{"v_s", std::string(velocity_unit), 1e-5 * top_speed, 10.0 * top_speed}, {"delta", "1", 0.05, 20.0}};
}

StribeckFactor stribeckFactor(const Eigen::Ref<const Eigen::ArrayXd>& log_speed, double v_s, double delta) {
  StribeckFactor factor;
  factor.exponent = (delta * (log_speed - std::log(v_s))).min(50.0).exp();
  factor.value = (-factor.exponent).exp();
  return factor;
}

}  // namespace simgap
