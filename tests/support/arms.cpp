#include "support/arms.h"

#include <algorithm>

#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Part sphere(double mass, const Vector3d& position, double radius) {
  Part part;
  part.shape = Part::Shape::kSphere;
  part.name = "sphere";
  part.mass = mass;
  part.position = position;
  part.radius = radius;
  return part;
}

Part cylinder(double mass, const Vector3d& position, const Vector3d& axis, double radius, double length) {
  Part part = sphere(mass, position, radius);
  part.shape = Part::Shape::kCylinder;
  part.name = "cylinder";
  part.axis = axis.normalized();
  part.length = length;
  return part;
}

Part box(double mass, const Vector3d& position, const Vector3d& size) {
  Part part = sphere(mass, position, 0.0);
  part.shape = Part::Shape::kBox;
  part.name = "box";
  part.size = size;
  return part;
}

ArmModel torso() {
  ArmModel model;
  model.name = "test";
  model.bodies.push_back({"torso", true, {}, {}});
  model.motor_defaults = {0.8, 0.0003, 0.011, 0.011, 2e-6, 1e-6, 0.002, 12.0};
  model.gearbox_defaults = {72.0, 0.72, 1e-5, 0.002, 0.03};
  return model;
}

Joint& addLink(ArmModel& model, int parent, JointType type, const Vector3d& parent_position,
               const std::vector<Part>& parts) {
  const int child = static_cast<int>(model.bodies.size());
  model.bodies.push_back({"link" + std::to_string(child), false, parts, {}});
  Joint joint;
  joint.name = "joint" + std::to_string(child);
  joint.type = type;
  joint.parent = parent;
  joint.child = child;
  joint.parent_position = parent_position;
  model.joints.push_back(joint);
  return model.joints.back();
}

Muscle& addMuscle(ArmModel& model, const Attachment& from, const Attachment& to, double slack_length) {
  Muscle muscle;
  muscle.name = "muscle" + std::to_string(model.muscles.size() + 1);
  muscle.attachments = {from, to};
  muscle.shock_cord = {0.08, 900.0, 15.0};
  muscle.kite_line_length = slack_length - muscle.shock_cord.rest_length;
  muscle.spindle_radius = 0.006;
  muscle.motor = model.motor_defaults;
  muscle.gearbox = model.gearbox_defaults;
  model.muscles.push_back(muscle);
  return model.muscles.back();
}

ArmModel pendulum(JointType type) {
  ArmModel model = torso();
  addLink(model, 0, type, Vector3d::Zero(), {sphere(kPendulumMass, {0.0, 0.0, -kPendulumLength})});
  return model;
}

std::filesystem::path dataFile(const std::string& name) {
  return std::filesystem::path(SIMGAP_SOURCE_DIR) / "data" / name;
}

ArmModel exampleArm(const std::string& name) { return readArm(YamlNode::load(dataFile(name) / "arm.yaml")); }

JointPosition hingeAt(double angle) { return {Eigen::Quaterniond::Identity(), angle}; }

JointPosition ballAt(double angle, const Vector3d& axis) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())), 0.0};
}

Vector3d randomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random);
  const double y = normal(random);
  return Vector3d(x, y, normal(random)).normalized();
}

Eigen::Quaterniond randomRotation(std::mt19937& random) {
  const double angle = uniform(random, 0.0, 3.0);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, randomDirection(random)));
}

double uniform(std::mt19937& random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

double largestError(const ArmModel& model, std::span<const JointPosition> a, std::span<const JointPosition> b) {
  double largest = 0.0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    largest = std::max(largest, jointError(model.joints[j].type, a[j], b[j]));
  }
  return largest;
}

std::vector<Vector3d> velocitiesBetween(const ArmModel& model, std::span<const JointPosition> before,
                                        std::span<const JointPosition> after, double step) {
  std::vector<Vector3d> velocities;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].type == JointType::kRevolute) {
      velocities.emplace_back((after[j].angle - before[j].angle) / step, 0.0, 0.0);
      continue;
    }
    Eigen::Quaterniond turn = before[j].rotation.conjugate() * after[j].rotation;
    if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
    const double sine = turn.vec().norm();
    const double angle = 2.0 * std::atan2(sine, turn.w());
    velocities.push_back(sine > 0.0 ? Vector3d(turn.vec() * (angle / (sine * step))) : Vector3d::Zero());
  }
  return velocities;
}

namespace {

// Of a part about its own centre, in the body's axes.
Matrix3d inertiaOfPart(const Part& part) {
  const Vector3d square = part.size.cwiseAbs2();
  const double disc = part.radius * part.radius;
  switch (part.shape) {
    case Part::Shape::kSphere:
      return Matrix3d::Identity() * (0.4 * part.mass * disc);
    case Part::Shape::kBox:
      return Vector3d(square.y() + square.z(), square.x() + square.z(), square.x() + square.y()).asDiagonal() *
             Matrix3d::Identity() * (part.mass / 12.0);
    default:  // other shapes have tests of their own
      break;
  }
  const Matrix3d from_z = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), part.axis).toRotationMatrix();
  const double across = part.mass * (disc / 4.0 + part.length * part.length / 12.0);
  return from_z * Vector3d(across, across, part.mass * disc / 2.0).asDiagonal() * from_z.transpose();
}

}  // namespace

Mechanics mechanics(const ArmModel& model, std::span<const JointPosition> positions,
                    std::span<const Vector3d> velocities) {
  const std::vector<BodyInWorld> bodies = bodiesInWorld(model, positions);
  std::vector<Vector3d> spin(bodies.size(), Vector3d::Zero());
  std::vector<Vector3d> drift(bodies.size(), Vector3d::Zero());  // of the body's origin
  Mechanics sum;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const BodyInWorld& child = bodies[joint.child];
    const Vector3d relative =
        joint.type == JointType::kSpherical ? velocities[j] : Vector3d(joint.axis * velocities[j].x());
    const Vector3d pivot = bodies[joint.parent] * joint.parent_position;
    const Vector3d pivot_velocity = drift[joint.parent] + spin[joint.parent].cross(pivot - bodies[joint.parent].origin);
    spin[joint.child] = spin[joint.parent] + child.rotation * relative;
    drift[joint.child] = pivot_velocity + spin[joint.child].cross(child.origin - pivot);
    for (const Part& part : model.bodies[joint.child].parts) {
      const Vector3d centre = child * part.position;
      const Vector3d velocity = drift[joint.child] + spin[joint.child].cross(centre - child.origin);
      const Vector3d own = child.rotation * inertiaOfPart(part) * child.rotation.transpose() * spin[joint.child];
      sum.kinetic += 0.5 * (part.mass * velocity.squaredNorm() + spin[joint.child].dot(own));
      sum.potential -= part.mass * model.gravity.dot(centre);
      sum.angular_momentum += part.mass * centre.cross(velocity) + own;
    }
  }
  return sum;
}

}  // namespace simgap::test
