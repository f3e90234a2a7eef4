#include "simgap/simulate/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/joint_kind.h"
#include "simgap/simulate/equilibrium_arm.h"
#include "simgap/simulate/possible_commands.h"

namespace simgap {
namespace {

constexpr double kMostChange = 0.1 * kDegree;  ///< [rad], of a slide as JointKind::counted

std::vector<double> lattice(double start, double end, double rate) { return sensorTimes({.rate = rate}, start, end); }

std::string whoFailed(const ArmModel& model, const MotionOutcome& outcome) {
  if (outcome.joint >= 0) return "joint " + model.joints[outcome.joint].name;
  return outcome.muscle >= 0 ? "muscle " + model.muscles[outcome.muscle].name : "the arm";
}

/// The largest step, halving by halving, at which a motion comes to its end; 0 when none is found.
double stepThatHolds(const ArmModel& model, const MotionCommands& commands, const MotionStart& start, double end,
                     RolloutOptions options) {
  constexpr double kSmallest = 2e-5;  // [s]
  const std::vector<double> times = {end};
  MotionTrack track;
  for (options.step *= 0.5; options.step >= kSmallest; options.step *= 0.5) {
    if (Rollout(model, options).run(commands, start, times, track).finished) return options.step;
  }
  return 0.0;
}

[[noreturn]] void failBlownUp(const ArmModel& model, const MotionCommands& commands, const MotionStart& start,
                              double end, const RolloutOptions& options, const MotionOutcome& outcome) {
  const double step = stepThatHolds(model, commands, start, end, options);
  throw NumericsError(
      fmt::format("the simulation blew up at {:.3f} s of the commands' clock: {} ran away at a step of {:g} s; {}",
                  outcome.time, whoFailed(model, outcome), options.step,
                  step > 0.0 ? fmt::format("a step of {:g} s holds", step)
                             : "no step down to 2e-05 s holds: look for a mass, inertia or stiffness that no arm has"));
}

MotionTrack play(const ArmModel& model, const MotionCommands& commands, const MotionStart& start,
                 std::span<const double> times, const RolloutOptions& options, MotionOutcome& outcome) {
  MotionTrack track;
  Rollout rollout(model, options);
  outcome = rollout.run(commands, start, times, track);
  return track;
}

double rangeOf(const std::vector<double>& values) {
  const auto [lowest, highest] = std::ranges::minmax(values);
  return highest - lowest;
}

/// Of weight, cords and, unless the arm is thought at rest, motion at every row. [J]
std::vector<double> energies(const ArmModel& model, const MotionTrack& track, bool at_rest = false) {
  BulletArm arm(model, {});
  std::vector<double> energy;
  std::vector<double> shafts(model.muscles.size());
  for (std::size_t row = 0; row < track.times.size(); ++row) {
    stopIfInterrupted();
    arm.setJointPositions(track.jointsAt(row));
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      if (!at_rest) arm.setJointVelocity(j, track.joint_velocities[row * track.joint_count + j]);
    }
    Eigen::Map<Eigen::VectorXd>(shafts.data(), std::ssize(shafts)) = track.shafts.col(row);
    arm.setShafts(shafts);
    const auto acting = track.line_commands.col(row);
    arm.setLineCommands(std::span(acting.data(), static_cast<std::size_t>(acting.size())), true);
    energy.push_back(arm.mechanicalEnergy());
  }
  return energy;
}

/// How far the joint that moves most is from where it began, as JointKind::counted.
double largestMotion(const ArmModel& model, const MotionTrack& track) {
  double most = 0.0;
  for (std::size_t i = 0; i < track.joints.size(); ++i) {
    const std::size_t j = i % track.joint_count;
    const JointType type = model.joints[j].type;
    most = std::max(most, kindOf(type).counted * jointError(type, track.joints[i], track.joints[j]));
  }
  return most;
}

StepCheck halve(const ArmModel& model, const MotionCommands& commands, const MotionStart& start,
                const MotionTrack& track, RolloutOptions options) {
  options.step *= 0.5;
  MotionOutcome outcome;
  const MotionTrack fine = play(model, commands, start, track.times, options, outcome);
  StepCheck check{outcome.finished, std::vector<double>(model.joints.size(), 0.0), 0.0};
  if (!outcome.finished) return check;
  for (std::size_t i = 0; i < track.joints.size(); ++i) {
    double& change = check.joint_change[i % track.joint_count];
    change = std::max(change, jointError(model.joints[i % track.joint_count].type, track.joints[i], fine.joints[i]));
  }
  // An arm that stands has no range of energy but that of rounding and of how exactly couplings hold.
  if (largestMotion(model, fine) <= kMostChange) return check;
  const std::vector<double> coarse_energy = energies(model, track), fine_energy = energies(model, fine);
  // Of what moves between weight, cords and motion: the sum is constant where nothing takes any.
  const std::vector<double> potential = energies(model, fine, /*at_rest=*/true);
  const double range = std::max(rangeOf(fine_energy), rangeOf(potential));
  for (std::size_t row = 0; row < fine_energy.size(); ++row) {
    if (!(range > 0.0)) break;
    check.energy_change = std::max(check.energy_change, std::abs(coarse_energy[row] - fine_energy[row]) / range);
  }
  return check;
}

void addJointHeader(const Joint& joint, std::vector<std::string>& velocities) {
  for (const std::string_view column : kindOf(joint.type).velocity_columns) {
    velocities.push_back(joint.name + std::string(column));
  }
}

/// Muscles whose motors had no voltage left to follow their set-point or force.
std::vector<std::string> atTheirSupply(const ArmModel& model, const MotionCommands& commands,
                                       const MotionTrack& track) {
  constexpr double kLongest = 0.2;  // share of the time: a step takes the whole supply for a while
  std::vector<std::string> notes;
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    if (commands.kinds[m] == CommandKind::kVoltage) continue;
    const double supply = model.muscles[m].motor.supply_voltage;
    const double share =
        (track.voltages.row(static_cast<Eigen::Index>(m)).array().abs() >= supply).cast<double>().mean();
    if (share < kLongest) continue;
    notes.push_back(
        fmt::format("{}: its motor stood at the supply of {:g} V for {:.0f} % of the time and did not follow "
                    "its commands",
                    model.muscles[m].name, supply, 100.0 * share));
  }
  return notes;
}

/// What half the step changes, where that is too much; else empty.
std::string noteOnStep(const ArmModel& model, const StepCheck& check, double step) {
  constexpr double kMostEnergy = 0.01;
  if (!check.finished)
    return fmt::format("the simulation blows up at half the step of {:g} s: it cannot be relied on", step);
  const auto counted = [&](std::size_t j) { return kindOf(model.joints[j].type).counted * check.joint_change[j]; };
  std::size_t worst = 0;
  for (std::size_t j = 1; j < model.joints.size(); ++j) worst = counted(j) > counted(worst) ? j : worst;
  if (counted(worst) <= kMostChange && check.energy_change <= kMostEnergy) return "";
  const JointKind& kind = kindOf(model.joints[worst].type);
  return fmt::format(
      "the step of {:g} s is too large: at half of it {} moves by {:.2f} {} and the energy by {:.2g} % "
      "of its range; try --step-s {:g}",
      step, model.joints[worst].name, kind.shown(check.joint_change[worst]), kind.error_unit,
      100.0 * check.energy_change, 0.5 * step);
}

}  // namespace

SimulationOptions SimulationOptions::read(const YamlNode& root) {
  root.at("format").oneOf({"simgap/simulation/1"});
  SimulationOptions options;
  options.rollout.step = root.findQuantity("step", "s", kPositive).value_or(options.rollout.step);
  options.rate = root.findQuantity("rate", "Hz", kPositive).value_or(options.rate);
  options.settle = root.findQuantity("settle", "s", kNonNegative).value_or(options.settle);
  if (const auto node = root.find("controllers")) options.rollout.controllers = ControllerOptions::read(*node);
  if (const auto node = root.find("sensors")) options.sensors = SensorOptions::read(*node);
  root.expectAllRead();
  return options;
}

std::string SimulationOptions::toYaml() const {
  return fmt::format("format: simgap/simulation/1\nstep_s: {}\nrate_Hz: {}\nsettle_s: {}\n{}{}", rollout.step, rate,
                     settle, rollout.controllers.toYaml(), sensors.toYaml());
}

MotionStart restUnder(const ArmModel& model, const MotionCommands& commands, double time, double settle) {
  MotionStart start;
  start.time = time;
  start.settle = settle;
  start.shafts.resize(model.commands());
  std::size_t row = 0;
  commands.at(time, row, start.shafts);
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    if (commands.kinds[m] != CommandKind::kSetpoint) start.shafts[m] = 0.0;
  }
  EquilibriumArm equilibrium(model);
  if (equilibrium.solve(start.shafts).stable) start.joints = equilibrium.joints();
  return start;
}

Simulation simulateMotion(const ArmModel& model, const MotionCommands& commands, const MotionStart& start, double end,
                          const SimulationOptions& options) {
  options.rollout.validate();
  Simulation simulation;
  simulation.start = start.time;
  simulation.end = end;
  simulation.simulated = end - start.time + start.settle;
  MotionOutcome outcome;
  const std::clock_t begin = std::clock();
  simulation.motion = play(model, commands, start, lattice(start.time, end, options.rate), options.rollout, outcome);
  simulation.processor = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  if (!outcome.finished) failBlownUp(model, commands, start, end, options.rollout, outcome);
  simulation.muscles = playAt(model, commands, start, sensorTimes(options.sensors.muscles, start.time, end), options);
  simulation.joints = playAt(model, commands, start, sensorTimes(options.sensors.joints, start.time, end), options);
  simulation.check = halve(model, commands, start, simulation.motion, options.rollout);
  return simulation;
}

MotionTrack playAt(const ArmModel& model, const MotionCommands& commands, const MotionStart& start,
                   std::span<const double> times, const SimulationOptions& options) {
  MotionOutcome outcome;
  MotionTrack track = play(model, commands, start, times, options.rollout, outcome);
  if (!outcome.finished) failBlownUp(model, commands, start, times.back(), options.rollout, outcome);
  return track;
}

std::vector<std::string> notesOn(const ArmModel& model, const MotionCommands& commands, const Simulation& simulation,
                                 double step) {
  std::vector<std::string> notes = atTheirSupply(model, commands, simulation.motion);
  if (std::string step_note = noteOnStep(model, simulation.check, step); !step_note.empty()) {
    notes.push_back(std::move(step_note));
  }
  return notes;
}

std::string motionCsv(const ArmModel& model, const MotionTrack& track) {
  std::vector<std::string> header{"time_s"}, velocities;
  for (const Joint& joint : model.joints) {
    for (const std::string& column : positionColumns(joint.type, joint.name)) header.push_back(column);
    addJointHeader(joint, velocities);
  }
  header.insert(header.end(), velocities.begin(), velocities.end());
  Eigen::MatrixXd motors = track.shaft_velocities;
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    motors.row(m) *= model.muscles[m].gearbox.ratio;
  }
  const std::array<std::tuple<const char*, const char*, const Eigen::MatrixXd*>, 6> channels = {
      {{"shaft", "rad", &track.shafts},
       {"motor_velocity", "rad_s", &motors},
       {"cord_length", "m", &track.cord_lengths},
       {"tension", "N", &track.forces},
       {"current", "A", &track.currents},
       {"voltage", "V", &track.voltages}}};
  for (const auto& [stem, unit, values] : channels) {
    for (const Muscle& muscle : model.muscles) header.push_back(fmt::format("{}_{}_{}", stem, muscle.name, unit));
  }
  const std::vector<const PassiveTendon*> lines = commandedLines(model);
  for (const PassiveTendon* line : lines) {
    header.push_back(fmt::format("{}_{}", line->commandStem(), line->kind->command.unit));
    header.push_back(line->kind->at_joint ? fmt::format("torque_{}_Nm", line->name)
                                          : fmt::format("tension_{}_N", line->name));
  }
  CsvWriter csv(header);
  for (std::size_t row = 0; row < track.times.size(); ++row) {
    csv.add(track.times[row]);
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      for (const double cell : kindOf(model.joints[j].type).cells(track.jointsAt(row)[j])) csv.add(cell);
    }
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Eigen::Vector3d& velocity = track.joint_velocities[row * track.joint_count + j];
      for (int k = 0; k < model.joints[j].degreesOfFreedom(); ++k) csv.add(velocity[k]);
    }
    for (const auto& [stem, unit, values] : channels) {
      for (Eigen::Index m = 0; m < values->rows(); ++m) csv.add((*values)(m, static_cast<Eigen::Index>(row)));
    }
    for (Eigen::Index l = 0; l < track.line_commands.rows(); ++l) {
      const auto column = static_cast<Eigen::Index>(row);
      // What acts along a line pulls its ends together; about a joint, a torque turns it forwards.
      const double sign = lines[l]->kind->at_joint ? -1.0 : 1.0;
      csv.add(track.line_commands(l, column)).add(sign * track.line_forces(l, column));
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
