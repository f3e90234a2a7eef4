/// \file
/// The arm in Bullet: rigid bodies and joints as one multibody of a headless world, muscles as forces on it.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "simgap/simulate/arm_observation.h"
#include "simgap/simulate/drive.h"

namespace simgap {

struct BulletArmOptions {
  double step = 0.002;             ///< [s] physics step; the controller's period is a whole number of steps
  double controller_rate = 500.0;  ///< [Hz] shaft-position controllers
  double shaft_gain = 50.0;        ///< K_p [V/rad]
  int drive_steps = 1;             ///< of a motion, within a physics step: 1, or 2 where bodies are slow beside drives
  bool operator==(const BulletArmOptions&) const = default;
  /// \throws ConfigError
  void validate() const;
};

/// One simulated arm. A worker keeps one and resets it for every pose; only a change of bodies or joints rebuilds the
/// world. After reset() the motion depends on the model and the references alone, to the last bit.
class BulletArm {
 public:
  BulletArm(const ArmModel& model, const BulletArmOptions& options);
  ~BulletArm();
  BulletArm(BulletArm&&) noexcept;
  BulletArm& operator=(BulletArm&&) noexcept;

  /// Takes another model, and resets. Its extensions act as in PotentialEnergy, but joint-stiction, which is here the
  /// joint's own Coulomb friction.
  void setModel(const ArmModel& model);
  /// When and after what a pose was recorded, for extensions that ask (PotentialEnergy::setHistory).
  void setHistory(double time, std::span<const double> shafts_before) {
    pose_time_ = time;
    shafts_before_.assign(shafts_before.begin(), shafts_before.end());
  }
  /// Shafts 0, joints at startPosition(), everything at rest.
  void reset();
  /// \param references  shape (model.commands()): of shafts [rad], behind them commands of lines, which act at once
  void setShaftReferences(std::span<const double> references);
  /// Places the joints, at rest; the shafts stay.
  void setJointPositions(std::span<const JointPosition> joints);
  /// Angular velocity of a joint's child relative to its parent, in the child's frame; revolute: (about the axis, -,
  /// -).
  void setJointVelocity(std::size_t joint, const Eigen::Vector3d& velocity);
  /// Advances one physics step.
  void step();

  /// \name Motion: what happens on the way to a rest (bullet_arm_motion.cpp)
  ///@{
  void setShafts(std::span<const double> shafts);  ///< places them, at rest and without current; shape (muscles) [rad]
  void setVoltage(std::size_t muscle, double voltage);  ///< of stepMotion(), held until it is set again [V]
  /// \name Lines that take a command, in the order of PoseLayout::lines
  ///@{
  /// What they follow from now on; `at_once`: and have followed. \param commands  shape (lines)
  void setLineCommands(std::span<const double> commands, bool at_once);
  std::size_t lines() const;
  double lineCommand(std::size_t line) const;  ///< what acts now: the pressure in a muscle that fills
  double lineForce(std::size_t line) const;    ///< [N], at a joint [N m], as of the last step of a motion
  ///@}
  /// Advances one physics step by an integrator of second order. The voltages are setVoltage()'s: no controller acts.
  void stepMotion();
  /// The same in its parts: the bodies' step, and drive_steps of the drives. Voltages may be set before each.
  void moveBodies();
  void stepDrives(int part);
  /// As setJointVelocity().
  Eigen::Vector3d jointVelocity(std::size_t joint) const;
  double shaftVelocity(std::size_t muscle) const;   ///< [rad/s]
  double voltage(std::size_t muscle) const;         ///< [V]
  double controllerGain(std::size_t muscle) const;  ///< by which effects change a shaft controller's, a factor
  double cordLength(std::size_t muscle) const;      ///< L_S [m], as of the last step
  double mechanicalEnergy();                        ///< of bodies, their weight and linear cords [J]
  ///@}

  double time() const;  ///< [s] since reset
  JointPosition jointPosition(std::size_t joint) const;
  std::vector<JointPosition> capturedPositions() const;              ///< of all joints, as markers show them
  void capturedPositions(std::vector<JointPosition>& joints) const;  ///< the same, into shape (joints)
  double jointSpeed(
      std::size_t joint) const;  ///< norm of its angular velocity [rad/s], of a slide as JointKind::counted
  /// How far a joint is from a position [rad], of a slide as JointKind::counted.
  double jointTravel(std::size_t joint, const JointPosition& from) const;
  double shaftAngle(std::size_t muscle) const;  ///< [rad]
  double shaftError(std::size_t muscle) const;  ///< reference - angle [rad]
  bool isFinite() const;                        ///< false once the simulation has blown up
  bool jointIsFinite(std::size_t joint) const;  ///< the same of one joint

  /// \name Sensors (000 section VI)
  ///@{
  double potentiometer(std::size_t muscle) const;  ///< S_P [rad] (eq. 13)
  double force(std::size_t muscle) const;          ///< F_L [N], as of the last step
  double current(std::size_t muscle) const;        ///< i [A]
  ///@}
  /// Expansion of the cord over its rest length, as of the last step; beyond 0.8 the linear cord is not valid (eq. 2).
  double cordExpansion(std::size_t muscle) const;
  void addLineCommands(std::vector<double>& commands) const;  ///< behind the muscles' angles: Pose::shafts

  std::size_t joints() const;
  std::size_t muscles() const;

 private:
  struct World;
  struct MuscleState;
  struct LinePath;
  struct CordState;
  struct Motion;
  struct MotionDeleter {
    void operator()(Motion* motion) const;
  };
  void build(const ArmModel& model);
  void updateKinematics();
  void applyMuscles();
  void applyMuscle(MuscleState& muscle, int index);
  void applyForce(int body, const Eigen::Vector3d& from_origin, const Eigen::Vector3d& force);
  LinePath linePath(const MuscleState& muscle, int index) const;
  void pull(const LinePath& path, double force);
  /// Length and rate of a line of any number of points; what it touches is left in touches_.
  struct PathState {
    double length, rate;
  };
  PathState followPath(const PathParts& way);
  void pullPath(const PathParts& way, double force);
  void applyTendons();
  void applyJointTorques();
  void applyJointSprings();
  void pushJoint(const Joint& joint, const Eigen::Vector3d& gradient);
  CordState cordState(const MuscleState& muscle, int index, double path_length, const DriveState& drive) const;
  Motion& motion();
  void forgetMotion();
  double pathLength(std::size_t muscle);  ///< [m]
  void setMotionEffects();
  void sagSupply();
  double driveStep() const { return options_.step / options_.drive_steps; }  ///< [s]
  void slipGuides(double step);
  void yieldCords();
  void touchRow(const PathParts& way, Eigen::VectorXd& row);
  void placePull(std::size_t index, const DriveState& middle);
  void placePassive(std::size_t index);
  void addJointGradient(std::size_t joint, const Eigen::Vector3d& gradient);
  void moveJoints(double step);

  BulletArmOptions options_;
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  Eigen::Vector3d gravity_;
  std::vector<JointPosition> start_;
  std::vector<MuscleState> muscles_;
  std::vector<ArmExtension> extensions_;
  struct Touch;
  struct Passive {
    const TendonKind* kind;
    TendonParameters p;
    PathParts way;
    double command = 0.0, told = 0.0;  ///< what acts, and what it follows
    double force = 0.0;
  };
  void followCommands(double step);
  struct Ropes;
  struct RopesDeleter {
    void operator()(Ropes* ropes) const;
  };
  void layRopes();
  void moveRopes();
  PathState followRope(int rope);
  PathState followLine(std::size_t muscle);  ///< of one that is not straight
  int ropeOf(std::size_t muscle) const { return rope_of_.empty() ? -1 : rope_of_[muscle]; }
  std::vector<int> rope_of_;  ///< shape (muscles): -1 without one; empty: no muscle has one
  std::unique_ptr<Ropes, RopesDeleter> ropes_;
  std::vector<PathParts> way_;             ///< shape (muscles), empty: straight
  std::vector<Passive> passive_;           ///< lines without motors
  std::vector<std::size_t> commanded_;     ///< those of them that take a command
  std::vector<Touch> touches_;             ///< of the line that followPath() was last called for
  std::vector<std::vector<int>> crossed_;  ///< per extension with a path: the joints its muscle crosses
  ArmObservation observation_;
  SupplyTerm supply_{0.0, 1.0};
  bool guided_ = false, yielding_ = false;  ///< whether any line loses at guides, any cord relaxes
  double pose_time_ = 0.0;
  std::vector<double> shafts_before_;
  std::vector<BodyInWorld> frames_;     ///< shape (bodies)
  std::vector<Eigen::Vector3d> spin_;   ///< angular velocity of each body in the world [rad/s]
  std::vector<Eigen::Vector3d> drift_;  ///< velocity of each body's origin in the world [m/s]
  std::unique_ptr<World> world_;
  std::unique_ptr<Motion, MotionDeleter> motion_;  ///< made by the first step of a motion
  long steps_ = 0;
  int controller_steps_ = 1;  ///< physics steps per controller period
};

}  // namespace simgap
