#include "drive_parameters.h"

#include <algorithm>
#include <cmath>

#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/measure/logs/channel_checks.h"

namespace simgap {

std::vector<ParameterSpec> driveParameters(const DriveFitOptions& options, double step) {
  constexpr double kTiny = 1e-12;
  const double latest = 8.0 * step;
  std::vector<ParameterSpec> all = {{"R", "ohm", kTiny, kInfinity},         {"L", "H", kTiny, kInfinity},
                                    {"K_E", "Vs", kTiny, kInfinity},        {"K_T", "Nm_A", kTiny, kInfinity},
                                    {"J_M", "kg_m2", kTiny, kInfinity},     {"mu_M", "Nms", 0.0, kInfinity},
                                    {"tau_CM", "Nm", 0.0, kInfinity},       {"eta", "1", 1e-3, 1.0},
                                    {"tau_CG", "Nm", 0.0, kInfinity},       {"mu_G", "Nms", 0.0, kInfinity},
                                    {"J_G", "kg_m2", 0.0, kInfinity},       {"voltage_delay", "s", -latest, latest},
                                    {"current_delay", "s", -latest, latest}};
  for (std::size_t i = 0; i < kDriveParameters; ++i) {
    all[i].fixed = i < kMotorParameters ? !options.fit_motor : !options.fit_gearbox;
  }
  constrain({options.fixed, options.bounds}, all);
  return all;
}

std::vector<double> typicalSizes(const MotorLog& log, std::span<const double> theta, double ratio) {
  const auto rms = [](const std::vector<double>& channel, double otherwise) {
    if (channel.empty()) return otherwise;
    return Eigen::Map<const Eigen::VectorXd>(channel.data(), std::ssize(channel)).norm() /
           std::sqrt(static_cast<double>(channel.size()));
  };
  constexpr double kShare = 0.1;
  const double voltage = rms(log.voltage, 0.0);
  const double current = rms(log.current, voltage / theta[kR]), velocity = rms(log.velocity, voltage / theta[kKe]);
  const double torque = kShare * theta[kKt] * current, damping = torque / std::max(velocity, 1e-300);
  const double step = meanStep(log);
  std::vector<double> sizes(kCount, 0.0);
  sizes[kL] = kShare * theta[kR] * step;
  sizes[kMuM] = damping, sizes[kTauM] = torque;
  sizes[kMuG] = ratio * ratio * damping, sizes[kTauG] = ratio * torque;
  sizes[kJg] = kShare * ratio * ratio * theta[kJm];
  sizes[kVoltageDelay] = sizes[kCurrentDelay] = step;
  return sizes;
}

double meanStep(const MotorLog& log) {
  double seconds = 0.0;
  std::size_t steps = 0;
  for (const Block& rows : splitRows(log.session, log.rows())) {
    seconds += log.time[rows.end - 1] - log.time[rows.begin];
    steps += rows.size() - 1;
  }
  return seconds / static_cast<double>(std::max<std::size_t>(steps, 1));
}

DriveDelays delaysOf(const MotorLog& log, std::span<const double> theta, double step) {
  const double current = theta[kCurrentDelay] / step;
  return log.voltage.empty() ? DriveDelays{current, 0.0} : DriveDelays{theta[kVoltageDelay] / step, current};
}

bool varies(const std::vector<double>& channel) { return !channel.empty() && !isConstant(channel); }

Motor motorOf(std::span<const double> theta) {
  return {theta[kR], theta[kL], theta[kKe], theta[kKt], theta[kJm], theta[kMuM], theta[kTauM], 0.0};
}

Gearbox gearboxOf(std::span<const double> theta, double ratio) {
  return {ratio, theta[kEta], theta[kJg], theta[kMuG], theta[kTauG]};
}

}  // namespace simgap
