#include "missing_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drive_parameters.h"
#include "drive_units.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/winding_signs.h"
#include "simgap/measure/logs/channel_checks.h"

namespace simgap {
namespace {

/// Without a velocity K_E acts only together with what moves the rotor, J_M / K_E and mu_M / K_E: it is an ideal
/// motor's.
void settleSpeedless(const MotorLog& log, DriveFitOptions& options, std::vector<std::string>& warnings) {
  if (options.fixed.contains("K_E")) return;
  const auto torque = options.fixed.find("K_T");
  if (torque == options.fixed.end() && !varies(log.load)) {
    throw DataError(log.file +
                    ": neither a velocity nor a load torque in the log: only ratios of K_E, K_T, J_M, mu_M and tau_CM "
                    "act on it, expected one of the constants to be known (--fix K_T=…, or K_E=…)");
  }
  if (torque != options.fixed.end()) {
    options.fixed["K_E"] = torque->second;
  } else {
    options.tie_constants = true;
  }
  warnings.emplace_back(
      "no velocity in the log: K_E is taken as K_T (an ideal motor's, in SI units); record velocity_rad_s, or --fix "
      "K_E=…");
}

/// Fixes what cannot be told without a load in the log.
void settleUnloaded(const MotorLog& log, DriveFitOptions& options, std::vector<std::string>& missing,
                    std::vector<std::string>& warnings) {
  const bool whole = *options.extent == DriveExtent::kWhole;
  const char* const lacks = log.load.empty() ? "no load torque in the log" : "load_torque_Nm is constant throughout";
  const char* const only = "J_M, mu_M and tau_CM hold only if nothing loaded the motor";
  for (const char* name : {"J_M", "mu_M", "tau_CM"}) {
    if (whole) break;
    if (options.fixed.try_emplace(name, 1.0).second) missing.emplace_back(name);
  }
  if (options.fixed.contains("K_T")) {
    if (whole) warnings.push_back(fmt::format("{}: {}; record load_torque_Nm", lacks, only));
  } else if (varies(log.voltage)) {
    options.tie_constants = true;
    warnings.push_back(
        fmt::format("{}: K_T is taken as K_E (an ideal motor's, in SI units){}; record load_torque_Nm, or --fix K_T=…",
                    lacks, whole ? fmt::format(", and {}", only) : ""));
  } else if (!options.fixed.contains("J_M")) {
    throw DataError(log.file +
                    ": neither a load torque nor a voltage in the log: only ratios of K_T, J_M, mu_M and tau_CM act on "
                    "it, expected one of them to be known (--fix K_T=…)");
  }
}

/// A motor that is switched off coasts; the winding's equation takes a voltage of 0 for shorted terminals, which brake.
void nameCoasting(const MotorLog& log, std::vector<std::string>& warnings) {
  constexpr double kMoves = 0.05;  // of the top speed
  if (!log.current.empty() || log.voltage.empty() || log.velocity.empty()) return;
  const auto size = [](double value) { return std::abs(value); };
  const double slow = kMoves * size(std::ranges::max(log.velocity, {}, size));
  std::ptrdiff_t coasting = 0;
  for (const Block& run : switchedOff(log.time, log.session, log.voltage, log.velocity, slow)) {
    coasting += std::count_if(log.velocity.begin() + run.begin, log.velocity.begin() + run.end,
                              [&](double velocity) { return size(velocity) > slow; });
  }
  if (coasting == 0) return;
  warnings.push_back(
      fmt::format("voltage_V is exactly 0 in {} rows of motion: the fit takes the terminals for shorted there, which "
                  "brakes; where they are open (a driver that lets go) leave these rows out, or record current_A",
                  coasting));
}

}  // namespace

std::vector<std::string> settleMissing(const MotorLog& log, DriveFitOptions& options,
                                       std::vector<std::string>& warnings) {
  std::vector<std::string> missing;
  const auto fail = [&](const std::string& sentence) { throw DataError(log.file + ": " + sentence); };
  const bool voltage = varies(log.voltage), current = varies(log.current), velocity = varies(log.velocity);
  if (!voltage && !current) fail("found neither a voltage nor a current that varies, expected one: record steps");
  if (!velocity && !(voltage && current)) {
    fail("found no velocity that varies, expected it, or voltage and current from which it follows");
  }
  if (!log.voltage.empty() && !voltage) fail("voltage_V is constant throughout: record steps of voltage");
  if (!log.velocity.empty() && !velocity) fail("velocity_rad_s is constant throughout: record steps with motion");
  if (!log.current.empty() && !current) fail("current_A is constant throughout: nothing can be found from it");
  if (options.fit_motor && voltage && current && velocity) {
    const std::string turned = oppositeWindingSign(log.voltage, log.current, log.velocity);
    if (!turned.empty()) fail(turned);
  }
  if (!options.fit_motor && voltage && current && velocity) {
    const std::string strange = strangeVelocity(log, options.motor, options.ratio);
    if (!strange.empty()) fail(strange);
  }
  if (options.fit_motor && !voltage) {
    warnings.emplace_back("no voltage in the log: R, L and K_E cannot be found; record voltage_V");
    for (const char* name : {"R", "L", "K_E"}) {
      if (!options.fixed.contains(name)) missing.emplace_back(name);
      options.fixed.try_emplace(name, 1.0);
    }
  }
  if (options.fit_motor && !velocity) settleSpeedless(log, options, warnings);
  if (options.fit_motor && !varies(log.load)) settleUnloaded(log, options, missing, warnings);
  if (options.fit_motor && voltage && !current && !options.fixed.contains("R")) {
    warnings.emplace_back(
        "no current in the log: R and the torques can be found only in proportion; record current_A, "
        "or --fix R=…");
  }
  if (options.fit_gearbox && !varies(log.load)) {
    fail(
        "the load torque is missing or constant: efficiency and gear friction cannot be told apart; record several "
        "loads in both directions");
  }
  if (options.fit_gearbox && log.current.empty())
    fail("found no current_A, expected it: it carries the motor's torque");
  // A delay is one against the velocity, or of the voltage against the current.
  if (!voltage) options.fixed.try_emplace("voltage_delay", 0.0);
  if (!current || !velocity) options.fixed.try_emplace("current_delay", 0.0);
  nameCoasting(log, warnings);
  return missing;
}

void settleEstimates(Uncertainty& uncertainty, const DriveFitOptions& options,
                     const std::vector<std::string>& missing) {
  if (options.tie_constants) {
    Estimate& torque = uncertainty.estimates[kKt];
    const Estimate& emf = uncertainty.estimates[kKe];
    torque.value = emf.value, torque.sd = emf.sd, torque.lower95 = emf.lower95, torque.upper95 = emf.upper95;
  }
  for (Estimate& e : uncertainty.estimates) {
    if (std::ranges::find(missing, e.name) == missing.end()) continue;
    e.value = e.sd = e.lower95 = e.upper95 = std::nan("");
    e.fixed = e.identifiable = false;
  }
}

}  // namespace simgap
