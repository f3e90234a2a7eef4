// What theta means: values of a model file and back.
#include <algorithm>
#include <cmath>

#include "simgap/fit/actuators/actuator_regression.h"

namespace simgap {

std::vector<double> ActuatorRegression::thetaOf(std::span<const Estimate> physical) const {
  const auto value = [&](const std::string& name, double otherwise) {
    const auto found = std::ranges::find(physical, name, &Estimate::name);
    return found == physical.end() ? otherwise : found->value;
  };
  std::vector<double> theta(parameters_.size());
  const bool gain = base_.law != nullptr;
  if (gain) theta[0] = 1.0 / value("k_a", 1.0);
  for (std::size_t i = gain ? 1 : 0; i < linear_; ++i) {
    theta[i] = value(parameters_[i].name, 0.0) * (times_gain_[i] ? theta[0] : 1.0);
  }
  for (std::size_t i = linear_; i < theta.size(); ++i) {
    const double otherwise = parameters_[i].name == kNuisance      ? 1e-6
                             : parameters_[i].name == kAngleOffset ? data_->angle->start
                                                                   : 1.0;
    theta[i] = value(parameters_[i].name, otherwise);
  }
  return theta;
}

std::vector<Estimate> ActuatorRegression::physical(std::span<const double> theta,
                                                   const Eigen::MatrixXd& covariance) const {
  std::vector<Estimate> list;
  const double gain = theta[0];
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const ParameterSpec& parameter = parameters_[i];
    const auto k = static_cast<Eigen::Index>(i);
    Estimate p{.name = parameter.name, .unit = parameter.unit, .value = theta[i]};
    p.at_bound = atBound(parameter, theta[i]);
    double variance = covariance(k, k);
    if (i == 0 && base_.law != nullptr) {
      p.value = 1.0 / gain;
      variance /= std::pow(gain, 4);
    } else if (i < linear_ && times_gain_[i]) {
      p.value = theta[i] / gain;
      variance = (variance - 2.0 * p.value * covariance(k, 0) + p.value * p.value * covariance(0, 0)) / (gain * gain);
    }
    p.sd = !parameter.fixed && covariance(k, k) > 0.0 ? std::sqrt(std::max(variance, 0.0)) : std::nan("");
    list.push_back(p);
  }
  return list;
}

std::vector<Extension> ActuatorRegression::extensions(std::span<const double> theta,
                                                      const Eigen::MatrixXd& covariance) const {
  const std::vector<Estimate> all = physical(theta, covariance);
  std::vector<Extension> list;
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    Extension& extension = list.emplace_back();
    extension.effect = effects_[e]->name;
    extension.form = effects_[e]->form;
    const auto take = [&](std::size_t i, std::string_view name) {
      extension.parameters.push_back(all[i]);
      extension.parameters.back().name = name;
    };
    for (std::size_t k = 0; k < effects_[e]->columns.size(); ++k)
      take(column_begin_[e] + k, effects_[e]->columns[k].name);
    for (std::size_t k = 0; k < effects_[e]->parameters.size(); ++k)
      take(p_begin_[e] + k, effects_[e]->parameters[k].name);
  }
  return list;
}

}  // namespace simgap
