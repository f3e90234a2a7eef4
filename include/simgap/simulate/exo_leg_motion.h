/// \file
/// A leg that stands up and sits down as a switch says: its equations of motion, and the motion with and without its
/// exoskeleton (002 fig. 14 and 15).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/measure/motion_commands.h"
#include "simgap/model/actuator/exo_leg.h"
#include "simgap/simulate/leg_switch.h"

namespace simgap {

/// Two links and a point mass in a plane, integrated by the classical Runge-Kutta method of fourth order.
class ExoLegMotion {
 public:
  using State = Eigen::Vector4d;  ///< angles of shank and thigh from the vertical [rad], their velocities [rad/s]

  explicit ExoLegMotion(const ExoLeg& leg) : leg_(leg) {}
  void reset(double ankle, double knee) { state_ = {ankle, ankle + knee, 0.0, 0.0}; }
  /// \param torques  of ankle and knee
  void step(const LegTorques& torques, double duration);

  double ankle() const { return state_[0]; }
  double knee() const { return state_[1] - state_[0]; }
  double ankleVelocity() const { return state_[2]; }
  double leaning() const { return leaning(state_); }  ///< the person's horizontal force at the hip [N]
  double energy() const;                              ///< kinetic, and of height [J]
  bool finite() const { return state_.allFinite(); }

 private:
  State derivative(const State& state, const LegTorques& torques) const;
  double leaning(const State& state) const;
  double seatPush(const State& state) const;

  ExoLeg leg_;
  State state_ = State::Zero();
};

struct ExoLegTrack {
  std::vector<double> time, ankle, knee, hip;     ///< [s], [rad], height [m]
  std::vector<double> ankle_assist, knee_assist;  ///< [N m]
  std::vector<double> leaning;                    ///< the person's horizontal force at the hip [N]
  std::vector<bool> up;                           ///< what was told
};

struct ExoLegRun {
  std::string name;  ///< "assisted", "alone"
  ExoLegTrack track;
  double standing = 0.0;    ///< share of the time it is told to be up in which the hip is at 95 % of its height
  double obeyed = 0.0;      ///< share of all the time in which the hip is above or below the middle, as it was told
  double at_limit = 0.0;    ///< share of ticks at which a drive was at its limit
  LegTorques largest = {};  ///< of the drives [N m]
};

struct ExoLegStudy {
  std::vector<ExoLegRun> runs;                ///< assisted, alone
  double start = 0.0, end = 0.0, step = 0.0;  ///< [s]
  double half_step = 0.0;                     ///< largest change of the hip's height at half the step [m]
  std::vector<std::string> notes;             ///< what a reader should know, as sentences
};

/// \param step  largest step of the integration [s]  \throws NumericsError: it blew up
ExoLegStudy studyExoLeg(const ExoLeg& leg, const LegSwitch& told, double end, double step);

}  // namespace simgap
