#include "support/statics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simgap/model/arm/arm_yaml.h"

namespace simgap::test {

ArmModel modelOf(const reality::Arm& arm, bool joint_coulomb) {
  return readArm(YamlNode::parse(reality::toYaml(arm, {.coulomb = joint_coulomb}), "arm.yaml"));
}

reality::Configuration configurationOf(const reality::Arm& arm, std::span<const JointPosition> joints) {
  reality::Configuration configuration(arm.links.size());
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    if (arm.links[i].joint == reality::Joint::kSpherical) {
      configuration[i].rotation = joints[i].rotation.toRotationMatrix();
    } else {
      configuration[i].angle = joints[i].angle;
    }
  }
  return configuration;
}

double largestAngle(const reality::Arm& arm, const reality::Configuration& a, const reality::Configuration& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const double angle = arm.links[i].joint == reality::Joint::kRevolute
                             ? std::abs(a[i].angle - b[i].angle)
                             : geodesicAngle(Eigen::Quaterniond(a[i].rotation), Eigen::Quaterniond(b[i].rotation));
    largest = std::max(largest, angle);
  }
  return largest;
}

PoseProtocol patientProtocol(double max_velocity) {
  PoseProtocol protocol;
  protocol.settle = 200.0;
  protocol.max_velocity = max_velocity;
  return protocol;
}

}  // namespace simgap::test
