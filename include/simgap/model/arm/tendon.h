/// \file
/// What pulls an arm: lines through space, and what lengthens or shortens them. SI units.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "simgap/model/arm/tendon_kind.h"

namespace simgap {

/// DC motor (000 eq. 8-9).
struct Motor {
  double resistance = 0.0;         ///< R [ohm]
  double inductance = 0.0;         ///< L [H]
  double back_emf_constant = 0.0;  ///< K_E [V s]
  double torque_constant = 0.0;    ///< K_T [N m/A]
  double inertia = 0.0;            ///< J_M [kg m^2]
  double viscous_friction = 0.0;   ///< mu_M [N m s]
  double coulomb_friction = 0.0;   ///< tau_CM [N m]
  double supply_voltage = 0.0;     ///< [V]
  bool operator==(const Motor&) const = default;
};

/// Gearbox (000 eq. 10-11).
struct Gearbox {
  double ratio = 1.0;             ///< N = omega_M / omega_G
  double efficiency = 1.0;        ///< eta; multiplies when back-driven too, as printed
  double inertia = 0.0;           ///< J_G [kg m^2]
  double viscous_friction = 0.0;  ///< mu_G [N m s]
  double coulomb_friction = 0.0;  ///< tau_CG [N m]
  bool operator==(const Gearbox&) const = default;
};

/// Elastic cord: a linear spring and damper that only pulls (000 eq. 2-4).
struct ShockCord {
  double rest_length = 0.0;  ///< L_SR [m]
  double stiffness = 0.0;    ///< k [N/m]
  double damping = 0.0;      ///< D [N s/m]

  static constexpr double kLinearRange = 0.8;  ///< of the rest length (000 eq. 2)

  /// Force of a cord of length L_S that lengthens at `rate`: max(0, k (L_S - L_SR) + D dL_S/dt) while taut, 0 when
  /// slack (000 eq. 3-4). [N]
  double force(double length, double rate) const noexcept {
    const double expansion = length - rest_length;
    return expansion > 0.0 ? std::max(0.0, stiffness * expansion + damping * rate) : 0.0;
  }
};

struct Attachment {
  int body = 0;                                     ///< index into bodies
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m] in the body's frame
  bool operator==(const Attachment&) const = default;
};

/// What a line meets on its way.
struct Station {
  enum class Kind {
    kPoint,    ///< runs through `at`
    kSurface,  ///< bends over a surface of the body `at.body`, where the straight way would pass through it
    kPulley,   ///< what follows is another branch and counts 1/divisor of its length
    kJoint     ///< wound on a wheel that turns with a joint: its length grows by radius q
  };
  Kind kind = Kind::kPoint;
  Attachment at;         ///< surface: its body, and the side point if there is one
  int surface = 0;       ///< index into the body's surfaces
  bool sided = false;    ///< passes the surface on the side of `at.point`, even where the straight way is free
  int side_body = -1;    ///< whose frame `at.point` then stands in; -1: that of the surface's body
  double divisor = 1.0;  ///< > 0
  int joint = 0;         ///< index into joints
  double radius = 0.0;   ///< [m], either sign; of a prismatic joint a plain number
};

/// The way of a line, in MuJoCo's conventions: from the first attachment over what is between to the second. Before and
/// after a surface or a pulley stands a point. A line over joints alone has both attachments at one point of a fixed
/// body.
struct TendonPath {
  std::array<Attachment, 2> attachments;
  std::vector<Station> between;  ///< empty: a straight line
  /// A surface that an extension puts on a stretch of it.
  struct Wrap {
    int stretch, body, surface;
  };
  std::optional<Wrap> wrap = {};
  bool straight() const { return between.empty(); }
  /// Wound on joints alone: no point of it moves.
  bool jointsOnly() const {
    return !between.empty() && attachments[0] == attachments[1] &&
           std::all_of(between.begin(), between.end(),
                       [](const Station& s) { return s.kind == Station::Kind::kJoint; });
  }
};

/// DC motor, gearbox, kite line wound on a spindle, shock cord (000 section V).
struct Muscle : TendonPath {
  std::string name;
  bool rope = false;  ///< a chain of nodes that collides with the parts of bodies (000 eq. 7); in Bullet alone
  double kite_line_length = 0.0;  ///< L_K0 [m]; may be negative: the straight, virtual line leaves out the bones
  ShockCord shock_cord;
  double spindle_radius = 0.0;         ///< r [m]
  double potentiometer_initial = 0.0;  ///< S_P0 [rad]
  Motor motor;
  Gearbox gearbox;

  /// Line left at shaft angle phi [rad]: L_K = L_K0 - r phi (000 eq. 12 integrated). [m]
  double kiteLineLength(double shaft) const noexcept { return kite_line_length - spindle_radius * shaft; }
};

/// What pulls besides a muscle: ligament, spring, weight (000 section IV), pneumatic muscle, motor at a joint.
struct PassiveTendon : TendonPath {
  std::string name;
  const TendonKind* kind = nullptr;
  TendonParameters p{};  ///< in the kind's order

  std::string commandStem() const { return std::string(kind->command.quantity) + "_" + name; }  ///< of its column
};

}  // namespace simgap
