#include "drive_parameters.h"

#include "simgap/measure/logs/channel_checks.h"

namespace simgap {

std::vector<ParameterSpec> driveParameters(const DriveFitOptions& options) {
  constexpr double kTiny = 1e-12;
  std::vector<ParameterSpec> all = {{"R", "ohm", kTiny, kInfinity},     {"L", "H", kTiny, kInfinity},
                                    {"K_E", "Vs", kTiny, kInfinity},    {"K_T", "Nm_A", kTiny, kInfinity},
                                    {"J_M", "kg_m2", kTiny, kInfinity}, {"mu_M", "Nms", 0.0, kInfinity},
                                    {"tau_CM", "Nm", 0.0, kInfinity},   {"eta", "1", 1e-3, 1.0},
                                    {"tau_CG", "Nm", 0.0, kInfinity},   {"mu_G", "Nms", 0.0, kInfinity},
                                    {"J_G", "kg_m2", 0.0, kInfinity}};
  for (std::size_t i = 0; i < kCount; ++i) {
    ParameterSpec& p = all[i];
    const auto bounds = options.bounds.find(p.name);
    if (bounds != options.bounds.end()) {
      p.lower = bounds->second.lower;
      p.upper = bounds->second.upper;
    }
    p.fixed = i < kFirstOfGearbox ? !options.fit_motor : !options.fit_gearbox;
    if (options.fixed.contains(p.name)) p.fixed = true;
  }
  return all;
}

bool varies(const std::vector<double>& channel) { return !channel.empty() && !isConstant(channel); }

Motor motorOf(std::span<const double> theta) {
  return {theta[kR], theta[kL], theta[kKe], theta[kKt], theta[kJm], theta[kMuM], theta[kTauM], 0.0};
}

Gearbox gearboxOf(std::span<const double> theta, double ratio) {
  return {ratio, theta[kEta], theta[kJg], theta[kMuG], theta[kTauG]};
}

}  // namespace simgap
