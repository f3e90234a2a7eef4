// Actuators of joints: which of them are motors or servos here.
#include <fmt/format.h>

#include "arm_exchange.h"
#include "mjcf_robot.h"

namespace simgap {

std::string_view notDriven(const MjcfActuator& actuator, const JointKind& joint) {
  const auto [b0, b1, b2] = actuator.bias;
  if (!joint.has_axis) return "the joint has no axis";
  if (joint.slides) return "slides have no drives here";
  if (!actuator.affine) return "its law is neither a motor's nor a position servo's";
  if (actuator.gear == 0.0 || actuator.gain == 0.0) return "its control moves nothing";
  if (b1 > 0.0 || b2 > 0.0) return "its bias drives the joint away";
  if (b1 == 0.0 && b2 != 0.0) return "it holds a velocity: only motors and position servos are modelled";
  return b1 == 0.0 && b0 != 0.0 ? "a constant torque beside its control: only motors and position servos are modelled"
                                : "";
}

PassiveTendon jointDrive(const MjcfActuator& actuator, int joint, double reference, XmlRobot& xml) {
  const std::string what = fmt::format("{} (actuator of a joint)", actuator.tag);
  PassiveTendon drive;
  Station wheel;
  wheel.kind = Station::Kind::kJoint;
  wheel.joint = joint;
  wheel.radius = 1.0;
  drive.between = {wheel};
  const auto [b0, b1, b2] = actuator.bias;
  if (b1 == 0.0) {
    drive.kind = tendonKind("joint-motor");
    drive.p = {1.0, actuator.gear * actuator.gain, 1.0, 0.0};
    xml.add(what, "a motor whose current in A is the control", false, actuator.place);
  } else {
    drive.kind = tendonKind("joint-servo");
    const double square = actuator.gear * actuator.gear, scale = -b1 * actuator.gear;
    drive.p = {-b1 * square, 0.0 + b0 / scale - reference, 0.0 - b2 * square};
    const double target = actuator.gain / scale;
    xml.add(what,
            target == 1.0 ? std::string("a servo whose target is the control")
                          : fmt::format("a servo whose target is {:.6g} of the control", target),
            target != 1.0, actuator.place);
  }
  if (actuator.force_range) xml.add("actuator forcerange", "left out: no limit of a torque", true, actuator.place);
  return drive;
}

}  // namespace simgap
