#include "simgap/fit/actuators/fitted_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drive_parameters.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"

namespace simgap {

std::vector<std::string> driveParameterNames() {
  std::vector<std::string> names;
  for (const ParameterSpec& p : driveParameters({})) names.push_back(p.name);
  return names;
}

JudgedDriveFit fitAndJudge(const MotorLog& log, const DriveFitOptions& options, const Holdout& holdout,
                           const std::optional<double>& block_s) {
  const double seconds = blockSeconds(block_s, log.time.back() - log.time.front());
  const std::vector<Block> blocks = splitBlocks(log.time, log.session, seconds);
  const JudgedRows rows = judgedRows(holdout, blocks);
  if (!rows.then_all) return {fitDrive(log, options, rows.fitted), std::nullopt, rows.words};

  JudgedDriveFit result{fitDrive(log, options), std::nullopt,
                        fmt::format("20 % of blocks of {:.3g} s, before the final fit to all rows", seconds)};
  DriveFitOptions same = options;
  same.extent = result.fit.extent;
  if (std::ranges::count(rows.fitted, false) > 0) result.trained = fitDrive(log, same, rows.fitted);
  return result;
}

Motor motorFrom(const FittedModel& model) {
  for (const char* divisor : {"R", "L", "K_E", "K_T", "J_M"}) {
    const double value = model.value(divisor);
    if (value > 0.0) continue;
    throw ConfigError(fmt::format("{}: found {} = {:g}, expected a number > 0", model.file, divisor, value));
  }
  return {model.value("R"),   model.value("L"),    model.value("K_E"),    model.value("K_T"),
          model.value("J_M"), model.value("mu_M"), model.value("tau_CM"), 0.0};
}

Eigen::MatrixXd motorCovarianceFrom(const FittedModel& model) {
  const std::vector<std::string> names = driveParameterNames();
  constexpr Eigen::Index kOfMotor = kMotorParameters;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kOfMotor, kOfMotor);
  const auto place = [&](Eigen::Index i) {
    return std::ranges::find(model.parameters, names[i], &Estimate::name) - model.parameters.begin();
  };
  bool known = model.covariance.size() > 0;
  for (Eigen::Index i = 0; i < kOfMotor; ++i) {
    const Estimate& parameter = model.parameters[place(i)];
    if (std::isfinite(parameter.sd)) known = true;
    if (model.covariance.size() == 0 && std::isfinite(parameter.sd)) covariance(i, i) = std::pow(parameter.sd, 2);
    for (Eigen::Index k = 0; k < kOfMotor && model.covariance.size() > 0; ++k) {
      covariance(i, k) = model.covariance(place(i), place(k));
    }
  }
  return known ? covariance : Eigen::MatrixXd();
}

Gearbox gearboxFrom(const FittedModel& model) {
  return {parseNumber(model.setting("transmission_ratio")).value_or(1.0), model.value("eta"), model.value("J_G"),
          model.value("mu_G"), model.value("tau_CG")};
}

DriveDelays delaysFrom(const FittedModel& model, const MotorLog& log) {
  std::vector<double> theta(kCount, 0.0);
  theta[kVoltageDelay] = parseNumber(model.setting("voltage_delay_s")).value_or(0.0);
  theta[kCurrentDelay] = parseNumber(model.setting("current_delay_s")).value_or(0.0);
  return delaysOf(log, theta, meanStep(log));
}

}  // namespace simgap
