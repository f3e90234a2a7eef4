/// Lagrange's equations of two links in a plane, phi from the vertical, with masses times levers A_ij, B_i:
///
///   [A_11 + I_1      A_12 cos d ] [phi_1'']   [ A_12 sin d phi_2'^2]   [g B_1 sin phi_1]
///   [A_12 cos d      A_22 + I_2 ] [phi_2''] + [-A_12 sin d phi_1'^2] - [g B_2 sin phi_2] = Q,    d = phi_1 - phi_2
///
///   Q_1 = tau_ankle - tau_knee,  Q_2 = tau_knee, with the joints' viscous friction and the forces x, z at the hip:
///   Q_i += l_i (x cos phi_i - z sin phi_i), of the person who leans and of the seat.
#include "simgap/simulate/exo_leg_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/simulate/tick_steps.h"

namespace simgap {
namespace {

/// A_11, A_12, A_22 without the links' own inertia. [kg m^2]
Eigen::Vector3d massMoments(const PlanarLeg& leg) {
  const LegSegment &shank = leg.shank, &thigh = leg.thigh;
  return {shank.mass * shank.centre * shank.centre + (thigh.mass + leg.load) * shank.length * shank.length,
          (thigh.mass * thigh.centre + leg.load * thigh.length) * shank.length,
          thigh.mass * thigh.centre * thigh.centre + leg.load * thigh.length * thigh.length};
}

/// x and z of the hip above the ankle by both angles. [m]
struct HipMotion {
  double x, z, x_rate, z_rate;
};
HipMotion hipOf(const PlanarLeg& leg, const ExoLegMotion::State& s) {
  const double l1 = leg.shank.length, l2 = leg.thigh.length;
  return {l1 * std::sin(s[0]) + l2 * std::sin(s[1]), l1 * std::cos(s[0]) + l2 * std::cos(s[1]),
          l1 * std::cos(s[0]) * s[2] + l2 * std::cos(s[1]) * s[3],
          -l1 * std::sin(s[0]) * s[2] - l2 * std::sin(s[1]) * s[3]};
}

/// The knee does not bend forwards. [N m]
double kneeStop(double knee, double rate) {
  constexpr double kStiffness = 3000.0, kDamping = 100.0;  // [N m/rad], [N m s/rad]
  return knee > 0.0 ? std::min(0.0, -kStiffness * knee - kDamping * rate) : 0.0;
}

void recordLeg(const ExoLeg& leg, const ExoLegMotion& motion, double time, const LegTorques& assist, bool up,
               ExoLegTrack& track) {
  track.time.push_back(time);
  track.ankle.push_back(motion.ankle());
  track.knee.push_back(motion.knee());
  track.hip.push_back(leg.leg.hipHeight(motion.ankle(), motion.knee()));
  track.ankle_assist.push_back(assist[0]);
  track.knee_assist.push_back(assist[1]);
  track.leaning.push_back(motion.leaning());
  track.up.push_back(up);
}

ExoLegTrack playLeg(const ExoLeg& leg, const LegSwitch& told, double end, double step, bool assisted) {
  const double start = told.times.front(), tick = 1.0 / leg.rate;
  const int steps = stepsPerTick(tick, step);
  const auto ticks = static_cast<long>(std::floor((end - start) * leg.rate + 1e-6));
  ExoLegMotion motion(leg);
  motion.reset(leg.sitting[0], leg.sitting[1]);
  ExoLegTrack track;
  double level = 0.0;
  std::size_t row = 0;
  for (long k = 0; k <= ticks; ++k) {
    if (k % 1000 == 0) stopIfInterrupted();
    const double time = start + static_cast<double>(k) * tick;
    while (row + 1 < told.times.size() && told.times[row + 1] <= time) ++row;
    const bool up = told.up[row];
    const LegTorques user =
        leg.leg.lifting(motion.ankle(), motion.knee(), leg.user.strength * leg.leg.mass() * leg.leg.gravity);
    const LegTorques assist = leg.assist.update(leg.leg, motion.ankle(), motion.knee(), up && assisted, tick, level);
    recordLeg(leg, motion, time, assist, up, track);
    for (int i = 0; i < steps; ++i) motion.step({user[0] + assist[0], user[1] + assist[1]}, tick / steps);
    if (!motion.finite()) {
      throw NumericsError(fmt::format("the leg blew up at {:.3f} s with steps of {:g} s, expected --step-s below that",
                                      time, tick / steps));
    }
  }
  return track;
}

ExoLegRun judged(const ExoLeg& leg, const std::string& name, ExoLegTrack track) {
  constexpr double kStands = 0.95;
  ExoLegRun run{name, std::move(track)};
  const ExoLegTrack& t = run.track;
  const double high = leg.leg.hipHeight(0.0, 0.0), low = leg.leg.hipHeight(leg.sitting[0], leg.sitting[1]);
  double up = 0.0, standing = 0.0, obeyed = 0.0, limited = 0.0;
  for (std::size_t i = 0; i < t.time.size(); ++i) {
    if (t.up[i]) up += 1.0;
    if (t.up[i] && t.hip[i] > kStands * high) standing += 1.0;
    if (t.up[i] == (t.hip[i] > 0.5 * (high + low))) obeyed += 1.0;
    run.largest[0] = std::max(run.largest[0], std::abs(t.ankle_assist[i]));
    run.largest[1] = std::max(run.largest[1], std::abs(t.knee_assist[i]));
    if (std::abs(t.ankle_assist[i]) >= leg.assist.limits[0] || std::abs(t.knee_assist[i]) >= leg.assist.limits[1]) {
      limited += 1.0;
    }
  }
  const auto count = static_cast<double>(t.time.size());
  run.standing = up > 0.0 ? standing / up : 0.0;
  run.obeyed = obeyed / count;
  run.at_limit = limited / count;
  return run;
}

}  // namespace

double ExoLegMotion::energy() const {
  const Eigen::Vector3d a = massMoments(leg_.leg);
  const auto [b1, b2] = leg_.leg.moments();
  return 0.5 * (a[0] + leg_.shank_inertia) * state_[2] * state_[2] +
         a[1] * std::cos(state_[0] - state_[1]) * state_[2] * state_[3] +
         0.5 * (a[2] + leg_.thigh_inertia) * state_[3] * state_[3] +
         leg_.leg.gravity * (b1 * std::cos(state_[0]) + b2 * std::cos(state_[1]));
}

/// Towards the straight way of the hip from the seat to above the foot.
double ExoLegMotion::leaning(const State& s) const {
  const State seated(leg_.sitting[0], leg_.sitting[0] + leg_.sitting[1], 0.0, 0.0);
  const HipMotion hip = hipOf(leg_.leg, s), seat = hipOf(leg_.leg, seated);
  const double high = leg_.leg.hipHeight(0.0, 0.0);
  const double wanted = seat.x * std::clamp((high - hip.z) / (high - seat.z), 0.0, 1.0);
  const double force = leg_.user.horizontal_stiffness * (wanted - hip.x) - leg_.user.horizontal_damping * hip.x_rate;
  return std::clamp(force, -leg_.user.horizontal_limit, leg_.user.horizontal_limit);
}

/// A spring with damping that only pushes. [N]
double ExoLegMotion::seatPush(const State& s) const {
  const HipMotion hip = hipOf(leg_.leg, s);
  const double below = leg_.leg.hipHeight(leg_.sitting[0], leg_.sitting[1]) - hip.z;
  return below > 0.0 ? std::max(0.0, leg_.seat_stiffness * below - leg_.seat_damping * hip.z_rate) : 0.0;
}

ExoLegMotion::State ExoLegMotion::derivative(const State& s, const LegTorques& torques) const {
  const Eigen::Vector3d a = massMoments(leg_.leg);
  const auto [b1, b2] = leg_.leg.moments();
  const double g = leg_.leg.gravity, l1 = leg_.leg.shank.length, l2 = leg_.leg.thigh.length, d = s[0] - s[1];
  const double ankle = torques[0] - leg_.viscous[0] * s[2], rate = s[3] - s[2];
  const double knee = torques[1] - leg_.viscous[1] * rate + kneeStop(s[1] - s[0], rate);
  const double x = leaning(s), z = seatPush(s);  // forces at the hip
  const double q1 = ankle - knee + l1 * (x * std::cos(s[0]) - z * std::sin(s[0])) - a[1] * std::sin(d) * s[3] * s[3] +
                    g * b1 * std::sin(s[0]);
  const double q2 = knee + l2 * (x * std::cos(s[1]) - z * std::sin(s[1])) + a[1] * std::sin(d) * s[2] * s[2] +
                    g * b2 * std::sin(s[1]);
  const double m11 = a[0] + leg_.shank_inertia, m12 = a[1] * std::cos(d), m22 = a[2] + leg_.thigh_inertia;
  const double determinant = m11 * m22 - m12 * m12;
  return {s[2], s[3], (m22 * q1 - m12 * q2) / determinant, (m11 * q2 - m12 * q1) / determinant};
}

void ExoLegMotion::step(const LegTorques& torques, double h) {
  const State k1 = derivative(state_, torques);
  const State k2 = derivative(state_ + 0.5 * h * k1, torques);
  const State k3 = derivative(state_ + 0.5 * h * k2, torques);
  const State k4 = derivative(state_ + h * k3, torques);
  state_ += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

LegSwitch readLegSwitch(const CsvTable& table) {
  LegSwitch told{readRisingTimes(table), {}};
  if (told.times.empty()) throw DataError(table.name() + ": no rows, expected states over time");
  const std::vector<std::string> states = table.text("state");
  bool up = false;
  for (std::size_t row = 0; row < states.size(); ++row) {
    if (states[row] != "up" && states[row] != "down" && states[row] != "none") {
      table.fail(row, fmt::format("found the state '{}', expected up, down or none", states[row]));
    }
    if (states[row] != "none") up = states[row] == "up";
    told.up.push_back(up);
  }
  return told;
}

ExoLegStudy studyExoLeg(const ExoLeg& leg, const LegSwitch& told, double end, double step) {
  constexpr double kMostChange = 1e-3;  // [m]
  const double taken = stepWithinTick(1.0 / leg.rate, step);
  ExoLegStudy study{{}, told.times.front(), end, taken, 0.0, {}};
  study.runs.push_back(judged(leg, "assisted", playLeg(leg, told, end, taken, true)));
  study.runs.push_back(judged(leg, "alone", playLeg(leg, told, end, taken, false)));
  const ExoLegTrack fine = playLeg(leg, told, end, 0.5 * taken, true);
  for (std::size_t i = 0; i < fine.hip.size(); ++i) {
    study.half_step = std::max(study.half_step, std::abs(fine.hip[i] - study.runs[0].track.hip[i]));
  }
  if (study.half_step > kMostChange) {
    study.notes.push_back(
        fmt::format("the step of {:g} s is too large: at half of it the hip moves by {:.3g} mm; try --step-s {:g}",
                    taken, 1e3 * study.half_step, 0.5 * taken));
  }
  return study;
}

}  // namespace simgap
