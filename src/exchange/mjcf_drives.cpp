// Actuators: which of them are motors, servos or muscles here.
#include <fmt/format.h>

#include <algorithm>

#include "arm_exchange.h"
#include "mjcf_robot.h"

namespace simgap {
namespace {

void nameForceRange(const MjcfActuator& actuator, XmlRobot& xml) {
  if (actuator.force_range)
    xml.add("actuator forcerange", "left out: no limit of a drive's force", true, actuator.place);
}

/// gear (gain u + b0 + b1 gear q + b2 gear dq/dt) is stiffness (target + offset - q) - damping dq/dt.
/// \param reference  MuJoCo's q less ours
PassiveTendon servo(const MjcfActuator& actuator, std::string_view kind, double reference, XmlRobot& xml) {
  const auto [b0, b1, b2] = actuator.bias;
  const double square = actuator.gear * actuator.gear, scale = -b1 * actuator.gear, target = actuator.gain / scale;
  PassiveTendon drive;
  drive.kind = tendonKind(kind);
  drive.p = {-b1 * square, 0.0 + b0 / scale - reference, 0.0 - b2 * square};
  xml.add(wordsOf(actuator),
          target == 1.0 ? std::string("a servo whose target is the control")
                        : fmt::format("a servo whose target is {:.6g} of the control", target),
          target != 1.0, actuator.place);
  nameForceRange(actuator, xml);
  return drive;
}

}  // namespace

std::string wordsOf(const MjcfActuator& actuator) {
  return fmt::format("{} (actuator of a {})", actuator.tag, actuator.tendon.empty() ? "joint" : "tendon");
}

std::string_view notDriven(const MjcfActuator& actuator, const JointKind& joint) {
  const auto [b0, b1, b2] = actuator.bias;
  if (!joint.has_axis) return "the joint has no axis";
  if (!actuator.affine) return "its law is neither a motor's nor a position servo's";
  if (actuator.gain == 0.0) return "its control moves nothing";
  if (b1 > 0.0 || b2 > 0.0) return "its bias drives the joint away";
  if (b1 == 0.0 && b2 != 0.0) return "it holds a velocity: only motors and position servos are modelled";
  if (b1 == 0.0 && joint.slides) return "slides have no motors here, only position servos";
  return b1 == 0.0 && b0 != 0.0 ? "a constant torque beside its control: only motors and position servos are modelled"
                                : "";
}

bool exertsNothing(const MjcfActuator& actuator) {
  const bool none = actuator.affine && actuator.gain == 0.0 && actuator.bias == std::array{0.0, 0.0, 0.0};
  return none || actuator.gear == 0.0;
}

bool isServo(const MjcfActuator& actuator) {
  return actuator.affine && actuator.gear != 0.0 && actuator.bias[1] < 0.0 && actuator.bias[2] <= 0.0;
}

bool pushes(const MjcfActuator& actuator) {
  if (!actuator.force_range) return true;
  // What lengthens the tendon is gear times the force.
  const auto [least, most] = *actuator.force_range;
  return actuator.gear < 0.0 ? least < 0.0 : most > 0.0;
}

void setServo(Muscle& muscle, const MjcfActuator& actuator, double stiffness, double offset, XmlRobot& xml) {
  muscle.shock_cord.stiffness = stiffness;
  muscle.shock_cord.damping = std::max(0.0, -actuator.gear * actuator.gear * actuator.bias[2]);
  muscle.kite_line_length = actuator.gear * actuator.bias[0] / stiffness - offset - muscle.shock_cord.rest_length;
  const double shortens = -actuator.gear * actuator.gain / stiffness;  // [m] per unit of control
  if (shortens > 0.0) {
    muscle.spindle_radius = shortens;
    xml.add(wordsOf(actuator), "a muscle whose shaft is the control; its motor and gearbox are placeholders", false,
            actuator.place);
  } else if (shortens == 0.0) {
    xml.add(wordsOf(actuator),
            "a muscle that its control does not move (its gain is 0); its spindle, motor and gearbox are placeholders",
            true, actuator.place);
  } else {
    xml.add(wordsOf(actuator),
            fmt::format("a muscle whose shaft is {:.6g} of the control; its motor and gearbox are placeholders",
                        shortens / muscle.spindle_radius),
            true, actuator.place);
  }
  if (pushes(actuator)) {
    xml.add(fmt::format("{} that pushes", actuator.tag), "a line only pulls here", true, actuator.place);
  } else if (actuator.force_range && actuator.gear * (*actuator.force_range)[actuator.gear < 0.0 ? 1 : 0] > -1e6) {
    xml.add("actuator forcerange", "left out: no limit of a line's force", true, actuator.place);
  }
}

PassiveTendon lineDrive(const MjcfActuator& actuator, const TendonPath& path, double offset, XmlRobot& xml) {
  PassiveTendon drive = servo(actuator, "line-servo", offset, xml);
  static_cast<TendonPath&>(drive) = path;
  return drive;
}

PassiveTendon jointDrive(const MjcfActuator& actuator, const Joint& joint, int index, double reference, XmlRobot& xml) {
  PassiveTendon drive;
  if (actuator.bias[1] != 0.0) {
    drive = servo(actuator, joint.slides() ? "line-servo" : "joint-servo", reference, xml);
  } else {
    drive.kind = tendonKind("joint-motor");
    drive.p = {1.0, actuator.gear * actuator.gain, 1.0, 0.0};
    xml.add(wordsOf(actuator), "a motor whose current in A is the control", false, actuator.place);
    nameForceRange(actuator, xml);
  }
  Station wheel;
  wheel.kind = Station::Kind::kJoint;
  wheel.joint = index;
  wheel.radius = 1.0;
  drive.between = {wheel};
  return drive;
}

}  // namespace simgap
