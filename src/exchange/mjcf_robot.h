/// \file
/// What an MJCF file says, in SI units and radians and with its defaults and frames worked out, before it is an arm.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mjcf_file.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/units.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

struct MjcfJoint {
  std::string said;  ///< its name in the file; empty without one
  std::string name;  ///< that of the arm's joint
  const JointKind* kind = nullptr;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m] in the body's frame
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();     ///< in the body's frame, unit length
  std::optional<std::array<double, 2>> range;          ///< [rad], [m], counted from the drawn pose
  double reference = 0.0;                              ///< MuJoCo's position in the drawn pose
  double stiffness = 0.0;                              ///< [N m/rad], [N/m]
  double spring_reference = 0.0;                       ///< [rad], [m], counted from the drawn pose
  double damping = 0.0;
  double friction_loss = 0.0;
  double armature = 0.0;
  std::array<double, 2> spring_damper = {0.0, 0.0};  ///< time constant [s], damping ratio; 0: stated ones hold
  std::string place;

  bool springDamped() const { return spring_damper[0] > 0.0 && spring_damper[1] > 0.0; }
};

struct MjcfBody {
  std::string said;                                         ///< its name in the file; empty without one
  std::string name;                                         ///< that of the arm's body
  int parent = -1;                                          ///< -1: the world
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  ///< in the parent's
  std::vector<MjcfJoint> joints;
  MassProperties mass;
  std::string place;  ///< "finger.xml:12"
};

/// A point or a wrapping surface on a body; surfaces' frames have their axis along z.
struct MjcfSite {
  int body = -1;  ///< -1: the world
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};
struct MjcfGeom {
  std::string name;                           ///< in the file; empty without one
  int body = -1;                              ///< -1: the world
  std::int64_t contype = 1, conaffinity = 1;  ///< bits
  std::string place;
};
struct MjcfSurface {
  std::string name;  ///< in the arm
  std::string place;
  int body = -1;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  bool cylinder = false;
  double radius = 0.0;
};

struct MjcfPathElement {
  enum class Kind { kSite, kSurface, kPulley };
  Kind kind = Kind::kSite;
  std::string name;  ///< of the site or geom
  std::string side;  ///< site; may be empty
  double divisor = 1.0;
};

struct MjcfTendon {
  std::string name;                                    ///< in the file; empty without one
  std::string line;                                    ///< that of the arm's muscle or passive line
  std::string beside;                                  ///< that of its spring beside a muscle
  std::vector<MjcfPathElement> path;                   ///< of a spatial one
  std::vector<std::pair<std::string, double>> joints;  ///< of a fixed one: joint, coefficient
  double stiffness = 0.0;                              ///< [N/m]
  double damping = 0.0;                                ///< [N s/m]
  double friction_loss = 0.0;                          ///< [N]
  std::optional<std::array<double, 2>> spring_length;  ///< [m]; empty: the length in the drawn pose
  std::optional<std::array<double, 2>> range;          ///< [m]
  std::string place;
};

struct MjcfCoupling {
  std::string joint, of;  ///< joint = offset + ratio * of, from the drawn pose
  double offset = 0.0, ratio = 0.0;
  std::string place;
};

/// force = gain ctrl + bias[0] + bias[1] length + bias[2] rate, times gear
struct MjcfActuator {
  std::string name, tag;  ///< the name in the file; empty without one
  std::string drive;      ///< that of the arm's drive of a joint
  std::string tendon, joint;
  double gear = 1.0;
  double gain = 1.0;
  std::array<double, 3> bias = {0.0, 0.0, 0.0};
  bool affine = true;  ///< the equation holds; else a muscle or another law
  std::optional<std::array<double, 2>> force_range;
  std::string place;
};

struct MjcfRobot {
  std::string name;
  Eigen::Vector3d gravity = {0.0, 0.0, -kEarthGravity};
  std::vector<MjcfBody> bodies;   ///< parents before children
  bool contacts = true;           ///< MuJoCo computes them
  bool neighbours_touch = false;  ///< bodies those that they hang on, too
  std::vector<MjcfGeom> geoms;
  std::map<std::string, MjcfSite> sites;
  std::map<std::string, MjcfSurface> surfaces;
  /// "site pin": what stands in bodies that float beside the robot and are left out, and what depends on it.
  std::set<std::string> loose;
  std::vector<MjcfTendon> tendons;
  std::vector<MjcfCoupling> couplings;
  std::vector<MjcfActuator> actuators;
};

/// \throws DataError as readMjcf
MjcfRobot readMjcfRobot(MjcfFile& file);

/// \name Its parts
///@{
void readMjcfBodies(MjcfFile& file, MjcfRobot& robot);
/// The compiler's bounds, balance and total mass, once all bodies are known.
void workOutMasses(const MjcfFile::Compiler& compiler, MjcfRobot& robot);
/// The stiffness and damping of joints that state a time constant and a damping ratio instead.
void setSpringDampers(MjcfRobot& robot);
void readMjcfTendons(MjcfFile& file, MjcfRobot& robot);
void readMjcfActuators(MjcfFile& file, MjcfRobot& robot);
/// What bodies, joints, lines and drives are called in the arm.
void nameMjcfParts(MjcfRobot& robot, XmlRobot& xml);
/// Why no drive of ours does what the actuator of a joint does; empty: one does.
std::string_view notDriven(const MjcfActuator& actuator, const JointKind& joint);
/// MuJoCo's torque of an affine actuator, gear (gain ctrl + b0 + b1 gear q + b2 gear dq/dt): a motor without bias, a
/// servo with b1 < 0, without a name. Its q counts from the joint's reference.
PassiveTendon jointDrive(const MjcfActuator& actuator, const Joint& joint, int index, double reference, XmlRobot& xml);
/// "position (actuator of a tendon)", for a remark.
std::string wordsOf(const MjcfActuator& actuator);
/// Whether neither its control nor its bias pulls or pushes.
bool exertsNothing(const MjcfActuator& actuator);
/// Whether its law is that of a position servo.
bool isServo(const MjcfActuator& actuator);
/// Whether an actuator of a tendon may push, too.
bool pushes(const MjcfActuator& actuator);
/// A servo that holds a tendon's length, force = gain u + bias0 + bias1 L: a cord behind a shaft.
/// \param stiffness  -bias1 gear^2 > 0 [N/m] \param offset  MuJoCo's length less ours
void setServo(Muscle& muscle, const MjcfActuator& actuator, double stiffness, double offset, XmlRobot& xml);
/// The same of a servo along a line. \param offset  MuJoCo's length less ours
PassiveTendon lineDrive(const MjcfActuator& actuator, const TendonPath& path, double offset, XmlRobot& xml);
/// The body that carries one and moves: bodies without joints are welded to their parents; -1: the world.
int carrierOf(const MjcfRobot& robot, int body);
/// A remark for every geom that may touch another.
void nameContacts(MjcfFile& file, const MjcfRobot& robot);
/// Adds one body's mass to what is known of it, both in the same frame.
MassProperties addMass(const MassProperties& a, const MassProperties& b);
/// Mass properties of a shape in another frame.
MassProperties inFrame(const MassProperties& mass, const Eigen::Isometry3d& frame);
///@}

}  // namespace simgap
