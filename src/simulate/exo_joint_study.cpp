#include "simgap/simulate/exo_joint_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "simgap/core/rotation.h"
#include "simgap/core/units.h"
#include "simgap/simulate/tick_steps.h"

namespace simgap {
namespace {

TorqueTracking trackingOf(const ExoJointTrack& track) {
  TorqueTracking tracking;
  const auto count = static_cast<double>(track.desired.size());
  for (std::size_t i = 0; i < track.desired.size(); ++i) {
    const double error = track.desired[i] - track.muscles[i] - track.motor[i];
    tracking.rms += error * error / count;
    tracking.largest = std::max(tracking.largest, std::abs(error));
    tracking.motor_rms += track.motor[i] * track.motor[i] / count;
    tracking.motor_largest = std::max(tracking.motor_largest, std::abs(track.motor[i]));
    if (track.missing[i] != 0.0) tracking.at_limit += 1.0 / count;
  }
  tracking.rms = std::sqrt(tracking.rms);
  tracking.motor_rms = std::sqrt(tracking.motor_rms);
  return tracking;
}

double largestDifference(const std::vector<double>& one, const std::vector<double>& other) {
  double largest = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) largest = std::max(largest, std::abs(one[i] - other[i]));
  return largest;
}

/// Above the middle of the way while more than the middle torque is asked for, below it otherwise.
double obeyedShare(const ExoJoint& joint, const ExoJointTrack& track) {
  const auto [lowest, highest] = std::ranges::minmax(track.angle);
  const double middle = 0.5 * (lowest + highest), torque = 0.5 * (joint.by_switch->up + joint.by_switch->down);
  double obeyed = 0.0;
  for (std::size_t i = 0; i < track.angle.size(); ++i) {
    if ((track.desired[i] > torque) == (track.angle[i] > middle)) obeyed += 1.0;
  }
  return obeyed / static_cast<double>(track.angle.size());
}

/// Which controllers are compared.
std::vector<ExoJointRun> runsOf(const ExoJoint& joint, const ExoJointCommands& commands, double step) {
  const auto run = [&](const char* name, bool tendons, bool motor) {
    return ExoJointRun{name, {.tendons = tendons, .motor = motor, .step = step}, {}, {}};
  };
  if (!commands.torque) return {run("pressures", true, joint.motor.has_value())};
  if (!joint.motor) return {run("tendon_alone", true, false), run("rigid_alone", false, false)};
  return {run("tendon_motor", true, true), run("tendon_alone", true, false), run("rigid_motor", false, true),
          run("rigid_alone", false, false)};
}

/// Where the supply cannot give what both muscles are to do besides the torque, or the torque leaves no room for it:
/// by how much it was missed, where by more than a tenth for more than a tenth of the time; empty otherwise. Momentary
/// misses are the valves'.
std::string missedCoContraction(const ExoJoint& joint, const ExoJointTrack& track) {
  using Kind = CoContraction::Kind;
  constexpr double kMuch = 0.1;
  const CoContraction& asked = joint.co_contraction;
  if (track.desired.empty() || asked.kind == Kind::kExtensorPressure) return {};
  const bool stiff = asked.kind == Kind::kStiffness;
  const AntagonistJoint& m = joint.muscles;
  double missed = 0.0, least = kInfinity;
  for (std::size_t i = 0; i < track.angle.size(); ++i) {
    const double had = stiff ? track.stiffness[i]
                             : std::min(m.flexorForce(track.flexor_pressure[i], track.angle[i]),
                                        m.extensorForce(track.extensor_pressure[i], track.angle[i]));
    if (had < (1.0 - kMuch) * asked.value) missed += 1.0 / static_cast<double>(track.angle.size());
    least = std::min(least, had);
  }
  if (missed <= kMuch) return {};
  return fmt::format("the muscles did not give the {} of {:.3g} {} for {:.1f} % of the time: it went down to {:.3g} {}",
                     stiff ? "stiffness" : "co-contraction", asked.value, stiff ? "Nm/rad" : "N", 100.0 * missed, least,
                     stiff ? "Nm/rad" : "N");
}

std::vector<std::string> notesOf(const ExoJoint& joint, const ExoJointStudy& study) {
  constexpr double kMostChange = 0.1 * kDegree;
  std::vector<std::string> notes;
  const ExoJointTrack& track = study.main().track;
  if (study.half_step > kMostChange) {
    notes.push_back(
        fmt::format("the step of {:g} s is too large: at half of it the joint moves by {:.2f} deg; try "
                    "--step-s {:g}",
                    study.main().play.step, study.half_step / kDegree, 0.5 * study.main().play.step));
  }
  const auto stopped = std::ranges::count_if(
      track.angle, [&](double angle) { return angle <= joint.link.lower || angle >= joint.link.upper; });
  if (stopped > 0) {
    notes.push_back(fmt::format("the joint stood at a limit for {:.1f} % of the time",
                                100.0 * static_cast<double>(stopped) / static_cast<double>(track.angle.size())));
  }
  const auto [lowest, highest] = std::ranges::minmax(track.angle);
  const AntagonistJoint& m = joint.muscles;
  const double least = std::min(m.flexorContraction(lowest), m.extensorContraction(highest));
  const double most = std::max(m.flexorContraction(highest), m.extensorContraction(lowest));
  if (least < joint.lowest_fitted || most > joint.highest_fitted) {
    notes.push_back(fmt::format("the muscles contracted by {:.3f} … {:.3f}, their fits have seen {:.3f} … {:.3f}",
                                least, most, joint.lowest_fitted, joint.highest_fitted));
  }
  if (std::string missed = missedCoContraction(joint, track); !missed.empty()) notes.push_back(std::move(missed));
  if (joint.motor && study.main().tracking.at_limit > 0.0) {
    notes.push_back(
        fmt::format("the motor was at its limit of {:.3g} Nm, and torque was missing, for {:.1f} % of the "
                    "time",
                    joint.motorLimit(), 100.0 * study.main().tracking.at_limit));
  }
  return notes;
}

}  // namespace

double ExoJointStudy::realTimeFactor() const { return simulated / std::max(processor, 1e-6); }

ExoJointStudy studyExoJoint(const ExoJoint& joint, const ExoJointCommands& commands, double end, double step) {
  ExoJointStudy study;
  study.start = commands.over_time.times.front();
  study.end = end;
  study.runs = runsOf(joint, commands, stepWithinTick(1.0 / joint.rate, step));
  for (ExoJointRun& run : study.runs) {
    const std::clock_t begin = std::clock();
    run.track = playExoJoint(joint, commands, end, run.play);
    if (&run == &study.runs.front()) {
      study.processor = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      study.simulated = end - study.start + run.play.settle;
    }
    if (commands.torque) run.tracking = trackingOf(run.track);
  }
  if (commands.switched) study.obeyed = obeyedShare(joint, study.main().track);
  ExoJointPlay fine = study.main().play;
  fine.step *= 0.5;
  study.half_step = largestDifference(playExoJoint(joint, commands, end, fine).angle, study.main().track.angle);
  study.notes = notesOf(joint, study);
  return study;
}

}  // namespace simgap
