/// \file
/// Physical causes that an arm model of plain muscles and joints does not know (docs/effects.md, "Pose sets"). One file
/// per effect in src/model/effects/arm; a model holds them under `extensions:`. An effect states what it is and fills
/// one hook: what it changes of a line's length, a cord's force, a muscle's path, gravity, masses, joint centres and
/// axes, joint torques, or of what the capture sees. Every hook returns its derivatives with it, so that both
/// simulations and the fits take an extended model as any other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/model/arm/arm_sizes.h"

namespace simgap {

inline constexpr int kMaxEffectParameters = 4;
using EffectParameters = std::array<double, kMaxEffectParameters>;  ///< values in the effect's order; the rest unused
using EffectSlopes = Eigen::Matrix<double, 3, kMaxEffectParameters>;

/// Numbers are the sample arm's; on another they are as many times as large as that arm is (`onArm`).
struct ArmEffectParameter {
  std::string_view name;
  std::string_view unit;          ///< SI, as a suffix; "1" when dimensionless
  Range range;                    ///< what a model file may hold; wider, never narrower, of an arm that is larger
  double neutral;                 ///< expected before any data; the first parameter's changes nothing
  double scale;                   ///< by how much it may plausibly differ from that (standard deviation of a prior)
  bool fitted = true;             ///< false: a choice or a moment, found by trying
  ArmSize size = ArmSize::kNone;  ///< of the arm that it goes with
  bool positive = false;          ///< a size of 0 or less is none: no friction drives, no line shrinks under load
};

/// \name What hooks are given and return. Derivatives `by_...`; those by effect parameters in the effect's order.
///@{
struct LineState {
  double shaft;         ///< [rad]
  double radius;        ///< of the spindle [m]
  double time;          ///< of the pose [s]; NaN when unknown
  double before = 0.0;  ///< shaft of the pose before [rad]; 0 (where poses start) when unknown
  double free = 0.0;    ///< kite line that is not wound up, L_K0 - r phi [m]
};
/// Line that a muscle has beyond L_K0 - r phi [m].
struct Lengthening {
  double length = 0.0, by_shaft = 0.0, by_radius = 0.0;
  EffectParameters by_parameter{};
};

/// What a taut cord has beyond the linear spring, at an expansion x > 0.
struct CordTerm {
  double energy = 0.0;                              ///< [J]
  double force = 0.0;                               ///< its derivative by x [N]
  double stiffness = 0.0;                           ///< and the next [N/m]
  double by_stiffness = 0.0, by_rest_length = 0.0;  ///< of the force
  double by_free = 0.0;                             ///< of the force, by the kite line that is not wound up
  EffectParameters by_parameter{};                  ///< of the force
};

/// A line that bends round the centre of a joint; index 0, 1: its ends, as vectors from that centre.
struct BentPath {
  double radius = 0.0;                                      ///< [m] of the ball that it runs round
  double length = 0.0;                                      ///< [m]
  std::array<Eigen::Vector3d, 2> slope;                     ///< of the length, by each end
  std::array<std::array<Eigen::Matrix3d, 2>, 2> curvature;  ///< second derivatives
  double length_by_parameter = 0.0;                         ///< by the effect's first parameter
  std::array<Eigen::Vector3d, 2> slope_by_parameter;
};

struct GravityTerm {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();         ///< [m/s^2]
  Eigen::Matrix3d by_gravity = Eigen::Matrix3d::Identity();  ///< by what it was without the effect
  EffectSlopes by_parameter = EffectSlopes::Zero();
};

/// Where a hinge's axis points, in the joint's frame; unit length.
struct AxisTerm {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  EffectSlopes by_parameter = EffectSlopes::Zero();  ///< at right angles to it
};

/// A mass on a body, on the way from its joint through its centre of mass.
struct PointMass {
  double mass;      ///< [kg]
  double distance;  ///< from the joint [m]
  EffectParameters mass_by_parameter{}, distance_by_parameter{};
};

/// Elastic energy of a joint.
struct JointTerm {
  double energy = 0.0;                                 ///< [J]
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< child's frame; revolute: about the axis, -, - [N m]
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();   ///< [N m/rad]
  EffectSlopes by_parameter = EffectSlopes::Zero();    ///< of the gradient
};

/// A joint that stops short of its equilibrium, on the side it comes from.
struct Stiction {
  double torque;       ///< [N m]
  bool from_previous;  ///< comes from the pose before; else from rest
};
/// What a muscle's motor and controller do otherwise.
struct MotorTerm {
  double gain = 1.0;                 ///< of its shaft controller, as a factor
  double current_limit = kInfinity;  ///< [A]
  double returned = 1.0;             ///< efficiency while the load drives the motor, of that while the motor drives
};

/// A cord that goes on yielding under a steady pull: a spring of `share` of its stiffness in line with a damper.
struct Relaxation {
  double share;
  double time;  ///< in which the branch gives up its force [s]
};

/// A guide between cord and body, against the way in which the line slips.
struct GuideTerm {
  double loss = 0.0;   ///< of the tension [1]
  double creep = 1.0;  ///< speed below which it grows with the slip [m/s]
};

/// A supply all motors hang on.
struct SupplyTerm {
  double resistance;  ///< [ohm]
  double time;        ///< of its capacitors, in which the voltage follows [s]
};
///@}

/// A named physical cause and what it changes. Exactly one hook is set. All are pure, allocate nothing, throw nothing.
/// docs/effects.md is written from these fields (tests/model/effects/effects_page_test.cpp); nothing outside its file
/// tests an effect by its name.
struct ArmEffect {
  /// kLine: a muscle or a line without a motor; kTendon: the latter.
  enum class Target { kNone, kMuscle, kMuscleOrAll, kLine, kTendon, kMovingBody, kBody, kJoint };

  std::string_view name;            ///< as in the catalogue; the file's stem
  std::string_view cause;           ///< one sentence a person understands
  std::string_view equation;        ///< one line
  std::string_view signature = {};  ///< what is left of the errors of a model without it; may be empty
  std::string_view remarks = {};    ///< what else to know of it; may be empty
  Target target;
  std::span<const ArmEffectParameter> parameters;
  std::span<const EffectParameters> starts;       ///< where fits of it begin; also all choices of what is not fitted
  std::span<const std::string_view> look_alikes;  ///< effects that poses hardly tell from it
  std::string_view separates_by;                  ///< the experiment that does
  bool needs_time = false;                        ///< of every pose
  bool from_moment = false;     ///< acts from a moment on, its second parameter, that a diagnosis has to search
  bool in_every_joint = false;  ///< of a real arm: to find it is no false alarm
  bool needs_motion = false;    ///< it acts while the arm moves: no pose shows it
  double law_sd = 0.05;         ///< of its size: what its law, and the model's steps, leave of real ones
  int from_previous = -1;  ///< parameter that says whether what it does depends on the pose before, which needs times

  Lengthening (*line)(const EffectParameters& p, const LineState& state) = nullptr;
  CordTerm (*cord)(const EffectParameters& p, double expansion, const ShockCord& cord,
                   const LineState& state) = nullptr;
  /// Of a muscle of two points over joints that turn. Round the centre of the joint in its second parameter other lines
  /// bend over a sphere of the radius in its first.
  /// \returns false where the straight line is free, and nothing is written
  bool (*path)(const EffectParameters& p, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
               BentPath& path) = nullptr;
  /// Added to a tendon's rest length [m]; its derivative is 1.
  double (*rest_shift)(const EffectParameters& p) = nullptr;
  GravityTerm (*gravity)(const EffectParameters& p, const Eigen::Vector3d& gravity) = nullptr;
  PointMass (*mass)(const EffectParameters& p) = nullptr;
  /// Added to the joint's parent_position [m]; its derivative is the identity.
  Eigen::Vector3d (*joint_shift)(const EffectParameters& p) = nullptr;
  /// Of a hinge. At position 0 the child stays where it is.
  AxisTerm (*hinge_axis)(const EffectParameters& p, const Eigen::Vector3d& axis) = nullptr;
  JointTerm (*joint_torque)(const EffectParameters& p, JointType type, const JointPosition& position) = nullptr;
  /// Rotation vector from the body's bones to its markers, in the body's frame [rad]; its derivative is the identity.
  Eigen::Vector3d (*marker_turn)(const EffectParameters& p) = nullptr;
  Stiction (*stiction)(const EffectParameters& p) = nullptr;

  /// \name Of effects that need motion: no derivatives, these come from differences of rollouts
  ///@{
  /// Numbers of the model itself.
  void (*change)(const EffectParameters& p, int target, ArmModel& model) = nullptr;
  double (*command_delay)(const EffectParameters& p) = nullptr;  ///< commands act that much later [s]
  double (*frame_delay)(const EffectParameters& p) = nullptr;    ///< joints are seen that much later than stamped [s]
  void (*motor)(const EffectParameters& p, MotorTerm& term) = nullptr;
  GuideTerm (*guide)(const EffectParameters& p) = nullptr;
  Relaxation (*relaxation)(const EffectParameters& p) = nullptr;
  SupplyTerm (*supply)(const EffectParameters& p) = nullptr;
  ///@}

  /// Whether a choice makes sense for a target; null: always. \returns what is expected instead, empty when it does
  std::string (*expected)(const EffectParameters& p, const ArmModel& model, int target) = nullptr;
};

/// What may be in a model of an arm that large.
Range rangeOn(const Range& range, ArmSize size, const ArmSizes& arm);
/// A parameter's numbers, and a start of an effect, on an arm of those sizes.
ArmEffectParameter onArm(const ArmEffectParameter& parameter, const ArmSizes& arm);
EffectParameters startOn(const ArmEffect& effect, const EffectParameters& start, const ArmSizes& arm);

namespace arm_effects {
std::span<const ArmEffect* const> all();
}

/// \returns null when there is none of that name.
const ArmEffect* findArmEffect(std::string_view name);

/// Names of what an effect may be at home in: muscles, bodies or joints; "" for the whole arm or all muscles.
std::vector<std::string> effectTargets(const ArmEffect& effect, const ArmModel& model);

/// An extension of a model, ready for use.
struct ArmExtension {
  const ArmEffect* effect = nullptr;
  int target = -1;  ///< index of the line (muscles, then tendons), body or joint; -1: the whole
  EffectParameters p{};
  bool on(int item) const { return target < 0 || target == item; }
};

/// In the order of the model's extensions, which must be valid.
std::vector<ArmExtension> resolveExtensions(const ArmModel& model);

/// What is wrong with an extension in a model; empty when nothing is. Puts its parameters into the effect's order.
std::string checkExtension(Extension& extension, const ArmModel& model);

/// An extension with given parameters, in the effect's order; sd unknown.
Extension makeExtension(const ArmEffect& effect, const std::string& target, const EffectParameters& p);

/// Works what effects do to gravity, masses, joint centres and axes, rest lengths and ways over surfaces into the model
/// itself; a payload becomes the last part of its body, a wrap the last surface of the one below its joint. What
/// muscles, joints and markers do stays to the simulation.
void applyToModel(std::span<const ArmExtension> extensions, ArmModel& model);

/// The same for good, wraps of muscles included: a model of numbers alone, for formats that know no effects.
/// \returns the extensions that are numbers now; those that cannot be stay in the model
std::vector<Extension> workExtensionsIn(ArmModel& model);

/// The line with that index: muscles, then tendons.
const TendonPath& lineOf(const ArmModel& model, int line);
/// Joints between a line's ends, from its first attachment on.
std::vector<int> jointsCrossed(const ArmModel& model, const TendonPath& line);
/// Whether a wrap bends a line as a surface on its way would, and not by the effect's own closed form, which knows two
/// points and joints that turn.
bool wrapsAsSurface(const ArmModel& model, int line);
/// The first stretch of a line over that joint that no surface bends yet; -1: none.
int freeStretchOver(const ArmModel& model, const TendonPath& line, int joint);
/// A tendon's parameter that is its rest length; -1: it has none.
int restLengthOf(const PassiveTendon& tendon);

/// What the capture sees of a simulated position when markers are turned against their bones: R_parent^-1 q R_child; of
/// a revolute joint the part of that about its axis. The turns are vectors in the joint's frames on both bodies.
JointPosition markedPosition(const Joint& joint, const JointPosition& position, const Eigen::Vector3d& parent_turn,
                             const Eigen::Vector3d& child_turn);

}  // namespace simgap
