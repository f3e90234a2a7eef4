/// \file
/// Potential energy of an arm with its shafts held, and its first two derivatives:
///
///   E(q, phi) = - sum_b m_b g.x_b(q)  +  sum_m 1/2 k max(0, L(q) - L_K0 + r phi - L_SR)^2     (000 eq. 3-6, 12)
///
/// q lives on SO(3)^n x R^m: a displacement w turns a spherical joint to R exp(w), w in the child's frame, and a
/// revolute one to q + w. Inside, every joint turns by a rotation vector w in the world; a point p that it carries at
/// r = p - pivot then moves by
///
///   dp = w_j x r_j,    d2p = w_i x (w_j x r_j)   for joint i at or above j in the tree,
///
/// symmetrised for i = j. Everything else follows from these two lines by the chain rule, as a 3-vector per joint and a
/// 3 x 3 block per pair of joints, projected on the joints' axes at the end.
///
/// A slide moves everything below it along its axis. Lines of more than two points, over surfaces, wheels and slides
/// are worked out by degree of freedom (potential_energy_paths.cpp), as are springs of joints; lines without motors add
/// their own energies V(L).
///
/// A model's extensions add to it (arm_effect.h): lines lengthen, cords stiffen, muscles bend, joints are pushed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap {

/// One number of the model that a steady pose depends on.
struct StaticParameter {
  enum class Kind {
    kGravity,
    kPartMass,
    kPartPosition,
    kParentPosition,  ///< of a joint
    kChildPosition,   ///< of a joint
    kAttachment,      ///< of a line, `part` its place in the file's list
    kWheelRadius,     ///< likewise
    kKiteLine,
    kRestLength,
    kStiffness,
    kSpindleRadius,
    kSurfaceRadius,    ///< of a body, `part` its surface
    kSurfacePosition,  ///< likewise
    kTendonParameter,  ///< `component` of a line without a motor
    kSpringStiffness,  ///< of a joint
    kSpringRest,       ///< likewise
    kExtension,        ///< parameter `component` of extension `item`
    kNone,             ///< dynamics only: moves no equilibrium
  };
  Kind kind = Kind::kNone;
  int item = 0;       ///< line (muscles, then tendons), joint or body
  int part = 0;       ///< part or surface of a body, place of a line's list
  int component = 0;  ///< x, y, z
};

/// Memory is taken in the constructor; no other call allocates while the structure (bodies, joints, attachments'
/// bodies) stays the same.
class PotentialEnergy {
 public:
  explicit PotentialEnergy(const ArmModel& model);
  /// Another model of the same structure.
  void setModel(const ArmModel& model);
  /// \param shafts  shape (model.commands()): angles of the muscles [rad], behind them commands of lines
  void setShafts(std::span<const double> shafts);
  /// When and after what a pose was recorded, for extensions that ask. \param time  [s]
  /// \param shafts_before  of the pose before, shape (muscles) [rad]; empty: unknown
  void setHistory(double time, std::span<const double> shafts_before);
  bool needsHistory() const;

  int degreesOfFreedom() const { return dofs_; }
  int firstDof(int joint) const { return first_dof_[joint]; }
  const ArmModel& model() const { return model_; }  ///< with applyToModel() done
  const std::vector<ArmExtension>& extensions() const { return extensions_; }

  /// Places the arm and computes everything that follows. \param joints  shape (joints)
  void evaluate(std::span<const JointPosition> joints);
  double energy() const { return energy_; }                      ///< [J]
  const Eigen::VectorXd& gradient() const { return gradient_; }  ///< shape (dof) [N m]; minus it is the torque
  const Eigen::MatrixXd& hessian() const { return hessian_; }    ///< shape (dof, dof) [N m/rad]
  /// Lengths of lines (muscles, then tendons) [m], and how they change with the joints.
  double length(std::size_t line) const { return muscles_[line].length; }
  /// \param[out] moment_arms  dL/dq, shape (dof) [m/rad]
  void momentArms(std::size_t line, Eigen::Ref<Eigen::VectorXd> moment_arms) const;
  double expansion(std::size_t muscle) const { return muscles_[muscle].expansion; }  ///< of its cord, < 0: slack [m]
  double tension(std::size_t muscle) const { return muscles_[muscle].force; }        ///< [N]

  /// Derivative of the gradient with respect to parameters, where evaluate() was last called.
  /// \param[out] columns  shape (dof, parameters.size()) [N m per unit of the parameter]
  void differentiate(std::span<const StaticParameter> parameters, Eigen::Ref<Eigen::MatrixXd> columns) const;
  /// The same with respect to the commands. \param[out] columns  shape (dof, model.commands()) [N m/rad, …]
  void differentiateByShafts(Eigen::Ref<Eigen::MatrixXd> columns) const;

 private:
  struct Link {  ///< the child of a joint
    Eigen::Matrix3d rotation;
    Eigen::Vector3d origin, pivot;
    Eigen::Vector3d axis;   ///< of a joint with one, in the world
    Eigen::Matrix3d basis;  ///< of a ball that is `turned`: its axes in the world
    Eigen::Vector3d axis_in_child;
    bool turned;  ///< the joint's frame on the child differs from the child's
    double mass, subtree_mass;
    Eigen::Vector3d centre_of_mass;  ///< in its own frame
    Eigen::Vector3d moment;          ///< sum of m x over the subtree
  };
  /// How a joint moves a muscle's line; only joints that move one end of it are listed.
  struct Lever {
    int joint;
    int end;                                           ///< the attachment that moves
    Eigen::Vector3d arm = Eigen::Vector3d::Zero();     ///< from the pivot to that attachment
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< dL/dw
  };
  struct Line {
    std::array<int, 2> joint;  ///< that carries each attachment's body, -1: fixed
    int first, last;           ///< levers, those of an end in the order of the tree
    double shaft = 0.0;        ///< or command
    double before = 0.0, expansion = 0.0, force = 0.0, length = 0.0;
    double stiffness = 0.0;   ///< d force / d expansion
    double by_command = 0.0;  ///< of a line without a motor
    bool extended = false;
    int bend = -1;                                         ///< of bends_, while the line touches its joint
    int path = -1;                                         ///< of paths_, for more than a straight line of rotations
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< u, from attachment 0 to 1
  };

  /// A line that touches a joint: three points, its ends and the joint's centre, and what moves them.
  struct Bend {
    int extension, muscle;
    int obstacle;                ///< joint
    std::array<int, 3> carrier;  ///< joint that carries each point, -1: fixed
    BentPath path;
    std::array<Eigen::Vector3d, 3> point, slope;
    std::vector<Eigen::Vector3d> moment;  ///< shape (joints): dL/dw
    Eigen::Matrix3d curvature(int a, int b) const;
  };
  /// A degree of freedom that moves a point against the frame of its stretch: +1 from the point's side, -1 from the
  /// frame's.
  struct Mover {
    int dof, joint;
    double sign;
  };
  /// What is between two points, in the frame of the surface or, without one, of the first point's body.
  struct PlacedStretch {
    PathStretch part;
    std::array<int, 2> carrier;                ///< joint that carries each point, -1: fixed
    int frame;                                 ///< joint that carries the frame
    std::array<std::vector<Mover>, 2> movers;  ///< of each point, from the point to the frame
    std::array<Eigen::Matrix3Xd, 2> columns;   ///< way of each point by its movers
    Stretch now;
  };
  struct LongPath {
    int line;
    std::vector<PlacedStretch> stretches;
    std::vector<PathWheel> wheels;
    std::vector<int> dofs;   ///< that change its length
    Eigen::VectorXd by_dof;  ///< dL/dq, shape (dof)
    bool slack = true;
  };
  /// What of an extension has to be known beyond its parameters.
  struct Applied {
    GravityTerm gravity{};
    AxisTerm axis{};
    int part = -1;  ///< the payload, of its body; the surface of a wrap
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
  };

  void place(std::span<const JointPosition> joints);
  void addGravity();
  void addMuscle(std::size_t muscle);
  void setForce(std::size_t muscle);  ///< from the line's length
  const TendonPath& pathOf(int line) const;
  int muscleCount() const { return static_cast<int>(model_.muscles.size()); }
  void makePath(int line);
  void refreshPath(LongPath& path);
  std::vector<Mover> moversBetween(int carrier, int frame) const;
  void placeAxes();
  void placePath(LongPath& path, std::span<const JointPosition> joints);
  void addPath(LongPath& path, std::span<const JointPosition> joints);
  void addCurvature(const PlacedStretch& stretch, double force);
  void addJointSprings(std::span<const JointPosition> joints);
  Eigen::Vector3d wayBy(const Mover& mover, const Eigen::Vector3d& from_pivot) const;
  /// A stretch whose points, frame and pivots shift.
  template <class PivotShift>
  void addStretchShift(const LongPath& path, const PlacedStretch& stretch, const std::array<Eigen::Vector3d, 2>& points,
                       const Eigen::Vector3d& frame, const PivotShift& pivot, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiatePathByStation(const LongPath& path, const StaticParameter& parameter,
                                  Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiatePathByJointShift(const LongPath& path, int joint, const Eigen::Vector3d& shift, bool pivot_moves,
                                     Eigen::Ref<Eigen::VectorXd> column) const;
  /// A hinge's axis changes by `change`, in the world. `turn`: what that turns everything below it by.
  void differentiateByAxis(int joint, const Eigen::Vector3d& change, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiatePathByAxis(const LongPath& path, int joint, const Eigen::Vector3d& change,
                               const Eigen::Vector3d& turn, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateBySurface(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateByTendon(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateBySpring(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  void prepareExtensions();
  void addJointTerms(std::span<const JointPosition> joints);
  bool bendLine(Line& line, std::size_t muscle, const std::array<Eigen::Vector3d, 2>& ends);
  void addBend(const Line& line, const Bend& bend);
  /// Points of `moved` shift by `shift`. \param arm_changes  for the points a joint carries
  Eigen::Vector3d bendShiftTerm(const Line& line, const Bend& bend, int joint, const Eigen::Vector3d& shift,
                                const std::array<bool, 3>& moved, bool arm_changes) const;
  void project();
  Eigen::Matrix3d& block(int upper, int lower) {
    return blocks_[static_cast<std::size_t>(upper) * links_.size() + lower];
  }
  Eigen::Vector3d pointInWorld(int joint, const Eigen::Vector3d& point) const {
    return joint < 0 ? point : Eigen::Vector3d(links_[joint].origin + links_[joint].rotation * point);
  }
  bool carries(int joint, int other) const;  ///< joint is `other` or above it
  /// Adds the derivative of a joint's gradient, a vector in the world, to a column.
  void addProjected(int joint, const Eigen::Vector3d& derivative, Eigen::Ref<Eigen::VectorXd> column) const;
  /// What a lever's gradient changes by when an end shifts; `arm_changes`: and its joint's pivot does not.
  Eigen::Vector3d shiftTerm(const Line& line, const Lever& lever, int end, const Eigen::Vector3d& shift,
                            bool arm_changes) const;
  void differentiateByJointShift(int joint, const Eigen::Vector3d& shift, bool pivot_moves,
                                 Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateBy(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateByMuscle(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateByMass(const StaticParameter& parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  Eigen::Vector3d liftArm(int joint, const Eigen::Vector3d& direction) const;
  void addWeight(int joint, const Eigen::Vector3d& point, double mass, const Eigen::Vector3d& direction,
                 double mass_change, double way, Eigen::Ref<Eigen::VectorXd> column) const;
  void differentiateByExtension(int extension, int parameter, Eigen::Ref<Eigen::VectorXd> column) const;
  /// Derivative of the gradient when a muscle's force changes by `factor`.
  void addForce(std::size_t muscle, double factor, Eigen::Ref<Eigen::VectorXd> column) const;
  CordTerm cordTerm(std::size_t muscle) const;
  Lengthening lengthening(std::size_t muscle) const;
  LineState lineState(std::size_t muscle) const {
    const Line& line = muscles_[muscle];
    const Muscle& of = model_.muscles[muscle];
    return {line.shaft, of.spindle_radius, time_, line.before, of.kiteLineLength(line.shaft)};
  }

  ArmModel model_;
  int dofs_ = 0;
  std::vector<int> first_dof_;      ///< shape (joints)
  std::vector<int> joint_of_body_;  ///< shape (bodies), -1: fixed
  std::vector<int> parent_joint_;   ///< shape (joints), -1: hangs on a fixed body
  std::vector<Link> links_;         ///< shape (joints)
  std::vector<Line> muscles_;       ///< and behind them lines without motors
  std::vector<LongPath> paths_;
  Eigen::Matrix3Xd axes_;                 ///< shape (3, dof), in the world; for paths
  std::vector<JointPosition> positions_;  ///< of the last evaluation; for wheels, springs and effects on axes
  bool springs_ = false;
  std::vector<Lever> levers_;
  std::vector<Eigen::Vector3d> moments_;  ///< shape (joints), gradient in the world
  std::vector<Eigen::Matrix3d> blocks_;   ///< shape (joints, joints), Hessian in the world, the upper triangle
  std::vector<ArmExtension> extensions_;
  std::vector<Applied> applied_;        ///< shape (extensions)
  std::vector<JointTerm> joint_terms_;  ///< shape (extensions)
  std::vector<Bend> bends_;             ///< muscles that may touch a joint
  double time_ = 0.0;                   ///< [s]
  double energy_ = 0.0;
  Eigen::VectorXd gradient_;
  Eigen::MatrixXd hessian_;
};

/// The parameters that a steady pose depends on, in the order of `paths` (ParameterPath::str()).
std::vector<StaticParameter> staticParameters(const ArmModel& model, std::span<const std::string> paths);

/// Moves of an arm with coupled joints: q = T q + offset, where followers take the place of their leaders' moves and
/// have none of their own. Shape (dof, dof); empty without couplings.
Eigen::MatrixXd couplingsOf(const PotentialEnergy& energy);

}  // namespace simgap
