// What a servo's rig logs of what happened: gaps, spikes, clipping, quantisation.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "reality/servo_rig.h"
#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

double rounded(double value, double digits) { return std::round(value * digits) / digits; }

/// The rows from `first` to `last` were never written.
void loseRows(ServoRecord& r, std::size_t first, std::size_t last) {
  const auto cut = [&](auto& values) {
    values.erase(values.begin() + static_cast<std::ptrdiff_t>(first),
                 values.begin() + static_cast<std::ptrdiff_t>(last));
  };
  cut(r.time), cut(r.effort), cut(r.position), cut(r.load), cut(r.joint), cut(r.temperature), cut(r.humidity);
  cut(r.supply), cut(r.neighbour), cut(r.speed), cut(r.extra), cut(r.moving), cut(r.session);
}

double clipLevel(const ServoRecord& r, double share) {
  std::vector<double> sizes;
  for (const double u : r.effort) sizes.push_back(std::fabs(u));
  std::ranges::sort(sizes);
  return sizes[static_cast<std::size_t>((1.0 - share) * static_cast<double>(sizes.size() - 1))];
}

}  // namespace

ServoRecord recordServo(const ServoRig& rig, const ServoSecret& secret) {
  ServoRecord r = driveServo(rig, secret);
  std::mt19937_64 random(rig.seed ^ 0x9e3779b97f4a7c15ULL);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> u;
  r.step = rig.effort_step;
  r.clip = rig.clipped_share > 0.0 ? clipLevel(r, rig.clipped_share) : 1e9;
  const double count = 2.0 * std::numbers::pi / rig.counts;
  double noise = 0.0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const double memory = rig.effort_memory;
    noise = memory * noise + rig.effort_noise * std::sqrt(1.0 - memory * memory) * normal(random);
    const bool off = rig.off_every > 0.0 && r.effort[i] == 0.0;  // what is off reports nothing, not even noise
    if (!off) r.effort[i] += noise;
    r.position[i] = std::floor(r.position[i] / count) * count;
    r.load[i] += rig.load_noise * normal(random);
    r.joint[i] += 5e-4 * normal(random);
    r.temperature[i] += 0.1 * normal(random);
    r.humidity[i] += 0.3 * normal(random);
    r.supply[i] += 0.01 * normal(random);
    r.neighbour[i] += 0.01 * normal(random);
    if (u(random) < rig.spike_share) {
      const double sign = u(random) - 0.5;
      r.position[i] += count * std::copysign(20.0 + 300.0 * u(random), sign);
    }
  }
  const auto first = static_cast<std::size_t>((0.3 + 0.4 * u(random)) * static_cast<double>(r.time.size()));
  loseRows(r, first, first + static_cast<std::size_t>(rig.gap * rig.rate));
  return r;
}

std::string ServoRecord::csv(bool without) const {
  const bool cable = mechanism == Mechanism::kCable, voltage = mechanism == Mechanism::kVoltageServo;
  std::vector<std::string> header = {"time_s", voltage ? "motor_voltage_V" : "motor_current_A",
                                     cable ? "motor_position_rad" : "position_rad"};
  if (cable) header.insert(header.end(), {"external_torque_Nm", "joint_position_rad"});
  header.insert(header.end(), {"temperature_degC", "humidity_percent", "supply_V", "neighbour_torque_Nm", "session"});
  CsvWriter writer(header);
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double read = std::clamp(effort[i] - (without ? extra[i] : 0.0), -clip, clip);
    writer.add(rounded(time[i], 1e4)).add(rounded(std::round(read / step) * step, 1e4)).add(rounded(position[i], 1e6));
    if (cable) writer.add(rounded(load[i], 1e4)).add(rounded(joint[i], 1e5));
    writer.add(rounded(temperature[i], 100.0)).add(rounded(humidity[i], 10.0)).add(rounded(supply[i], 1e3));
    writer.add(rounded(neighbour[i], 1e3)).add(static_cast<double>(session[i])).endRow();
  }
  return writer.text();
}

double expectedGain(const ServoRig& rig, const ServoSecret& secret) {
  const ServoRecord r = driveServo(rig, secret);
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 1; i < r.time.size(); ++i) {
    if (r.moving[i] && r.moving[i - 1] && r.session[i] == r.session[i - 1])
      rows.push_back(static_cast<Eigen::Index>(i));
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd x(n, 7);
  Eigen::VectorXd y(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(rows[k]);
    const double w = r.speed[i], way = w > 0.0 ? 1.0 : -1.0, slow = lorentzian(w, rig.stribeck_speed);
    const double dry = way * (rig.mechanism == Mechanism::kCable ? std::fabs(r.load[i]) : 1.0);
    const double pull = rig.mechanism == Mechanism::kCable ? 0.0 : (w - r.speed[i - 1]) * rig.rate;
    x.row(k) << r.load[i], dry, dry * slow, w, dry * slow * slow, pull, 0.0;
    y[k] = r.extra[i];
  }
  const Eigen::VectorXd rest = y - x * x.colPivHouseholderQr().solve(y);
  const double added = rest.squaredNorm() / static_cast<double>(n);
  return added / (added + rig.effort_noise * rig.effort_noise);
}

std::vector<std::string> diagnoseOptions(const ServoRig& rig) {
  if (rig.mechanism == Mechanism::kCable) return {"--ratio", "97.74"};
  return {"--bench", "bench.yaml"};
}

std::string benchYaml(const ServoRig& rig) {
  const std::string start = "format: simgap/bench/1\n";
  switch (rig.mechanism) {
    case Mechanism::kCable:
      return {};
    case Mechanism::kGearedJoint:
      return start + "load: free-axis\ninertia_kg_m2: fit\nbandwidth_Hz: 8\n";
    case Mechanism::kPendulum:
    case Mechanism::kVoltageServo:
      break;
  }
  return start + "load: pendulum\nmass_kg: " + std::to_string(rig.weight / (kServoGravity * kServoLever)) +
         "\nlength_m: " + std::to_string(kServoLever) + "\ninertia_kg_m2: fit\nbandwidth_Hz: 8\n";
}

}  // namespace simgap::reality
