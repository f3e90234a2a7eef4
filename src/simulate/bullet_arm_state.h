/// \file
/// What BulletArm holds: Bullet's objects, and its muscles.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "bullet_joint.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/joint_constraint_solver.h"

namespace simgap {

inline constexpr double kRunawaySpeed = 1e4;  // [rad/s]; no arm turns that fast, a simulation that blows up passes it

inline constexpr int kDriveParts = 8;  // of such a step

/// Bullet's multibody, and what a step of it needs.
struct BulletArm::World {
  btMultiBody body;
  JointConstraintSolver solver;
  btVector3 gravity{0.0, 0.0, 0.0};
  std::vector<BulletLink> links;   ///< shape (bodies)
  std::vector<int> link_of_joint;  ///< shape (joints)

  explicit World(int number_of_links)
      : body(number_of_links, 0.0, btVector3(0.0, 0.0, 0.0), /*fixedBase=*/true, /*canSleep=*/false) {
    body.setHasSelfCollision(false);
    body.setLinearDamping(0.0);
    body.setAngularDamping(0.0);
    body.setMaxCoordinateVelocity(10.0 * kRunawaySpeed);  // Bullet clamps at 100 rad/s, which would hide a runaway
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// What btMultiBodyDynamicsWorld::stepSimulation does for one multibody, to the last bit. The rest of it looks for
  /// collisions, of which there are none, and takes a quarter of the time.
  void step(double dt) {
    for (int link = 0; link < body.getNumLinks(); ++link) body.addLinkForce(link, gravity * body.getLinkMass(link));
    body.computeAccelerationsArticulatedBodyAlgorithmMultiDof(dt, scratch_scalars, scratch_vectors, scratch_matrices,
                                                              /*isConstraintPass=*/false,
                                                              /*jointFeedbackInWorldSpace=*/false,
                                                              /*jointFeedbackInJointFrame=*/false);
    solver.solve(dt);
    body.processDeltaVeeMultiDof2();
    body.stepPositionsMultiDof(dt);
    body.clearForcesAndTorques();
  }

  btAlignedObjectArray<btScalar> scratch_scalars;
  btAlignedObjectArray<btVector3> scratch_vectors;
  btAlignedObjectArray<btMatrix3x3> scratch_matrices;
};

/// What a step needs of a muscle, and its state.
struct BulletArm::MuscleState {
  MuscleState(const Muscle& muscle, double step)
      : attachments(muscle.attachments),
        kite_line_length(muscle.kite_line_length),
        shock_cord(muscle.shock_cord),
        spindle_radius(muscle.spindle_radius),
        supply_voltage(muscle.motor.supply_voltage),
        potentiometer_initial(muscle.potentiometer_initial),
        motor(muscle.motor),
        gearbox(muscle.gearbox),
        drive(muscle.motor, muscle.gearbox, step),
        drive_part(muscle.motor, muscle.gearbox, step / kDriveParts),
        part_seconds(step / kDriveParts) {}

  void setModel(const Muscle& muscle, double step) {
    if (muscle.motor != motor || muscle.gearbox != gearbox) {
      *this = MuscleState(muscle, step);
      return;
    }
    attachments = muscle.attachments;
    kite_line_length = muscle.kite_line_length;
    shock_cord = muscle.shock_cord;
    spindle_radius = muscle.spindle_radius;
    potentiometer_initial = muscle.potentiometer_initial;
  }

  void reset() {
    state = {};
    reference = voltage = force = expansion = 0.0;
    yielded = -1.0;
    supplied = 1.0;
  }

  /// What effects make of its motor.
  void setTerm(const MotorTerm& changed, double step) {
    if (changed.returned != term.returned) {
      Gearbox back = gearbox;
      back.efficiency *= changed.returned;
      returning = changed.returned == 1.0 ? std::nullopt : std::optional<Drive>(std::in_place, motor, back, step);
      returning_part =
          changed.returned == 1.0 ? std::nullopt : std::optional<Drive>(std::in_place, motor, back, step / kDriveParts);
    }
    term = changed;
  }

  bool limits(const DriveState& now) const {
    const double driving = voltage * supplied - motor.back_emf_constant * now.motor_velocity;
    return std::abs(driving) > motor.resistance * term.current_limit;
  }

  /// The voltage across the motor over the next `seconds`: the controller's, of a supply that may sag, from an
  /// amplifier that takes the current to its limit and no further.
  double motorVoltage(const DriveState& now, double seconds) const {
    const double given = voltage * supplied;
    if (term.current_limit == kInfinity) return given;
    const double kept =
        std::exp(-motor.resistance * seconds / motor.inductance);  // of the current, where it is not fed
    const auto towards = [&](double current) {
      const double drop = motor.resistance * (current - kept * now.current) / (1.0 - kept);
      return motor.back_emf_constant * now.motor_velocity + drop;
    };
    return std::clamp(given, towards(-term.current_limit), towards(term.current_limit));
  }

  /// A motion's step of the drive; in parts where the rotor starts or stops within it, so that it does at its time, and
  /// where the current is limited, whose voltage follows the speed.
  void stepDrive(DriveState& now, double load) const {
    const DriveState before = now;
    if (!limits(before)) {
      const bool returns = returning && now.current * now.motor_velocity < 0.0;
      (returns ? *returning : drive).step(now, voltage * supplied, load);
      if ((before.motor_velocity == 0.0) == (now.motor_velocity == 0.0)) return;
      now = before;
    }
    for (int part = 0; part < kDriveParts; ++part) {
      const bool back = returning && now.current * now.motor_velocity < 0.0;
      (back ? *returning_part : drive_part).step(now, motorVoltage(now, part_seconds), load);
    }
  }

  std::array<Attachment, 2> attachments;
  double kite_line_length;
  ShockCord shock_cord;
  double spindle_radius;
  double supply_voltage;
  double potentiometer_initial;
  Motor motor;
  Gearbox gearbox;
  Drive drive;
  Drive drive_part;  ///< of a step in which the rotor starts or stops
  double part_seconds;
  std::optional<Drive> returning, returning_part;  ///< while the load drives the motor, where that differs
  MotorTerm term;
  GuideTerm guide;
  Relaxation relaxation{0.0, 1.0};  ///< of the cord
  double relaxing = 0.0;            ///< 1 - exp(-step / time)
  double yielded = -1.0;            ///< what its damper has given way, y; < 0: all it can [m]
  double supplied = 1.0;            ///< the supply's voltage, of what it is without load
  DriveState state;
  double reference = 0.0;  ///< [rad]
  double voltage = 0.0;    ///< [V], held between controller ticks
  double force = 0.0;      ///< [N]
  double expansion = 0.0;  ///< of the cord, [m]
};

/// Where a line touches a body.
struct BulletArm::Touch {
  int body;
  Eigen::Vector3d arm;    ///< from the body's origin, in the world [m]
  Eigen::Vector3d slope;  ///< of the length by the point
};

/// Where a muscle's line runs, and how its length changes as the points that it touches move.
struct BulletArm::LinePath {
  double length;  ///< [m]
  std::array<Touch, 2> ends;
  std::optional<Touch> centre;  ///< of the joint that bends it
};

/// A cord at a length of its path and a state of its drive.
struct BulletArm::CordState {
  double length;          ///< L_S [m]
  double expansion;       ///< over the rest length; <= 0: slack [m]
  double elastic;         ///< k x, with what effects add to it while taut [N]
  double winding_radius;  ///< what a turn of the spindle winds up, per radian [m]
  double winding_rate;    ///< its part of dL_S/dt [m/s]
};

}  // namespace simgap
