#include "simgap/report/poses/arm_geometry.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/kinematics.h"

namespace simgap {
namespace {

void add(CsvWriter& csv, const Eigen::Vector3d& v) { csv.add(v.x()).add(v.y()).add(v.z()); }

const char* shapeName(Part::Shape shape) {
  switch (shape) {
    case Part::Shape::kCylinder:
      return "cylinder";
    case Part::Shape::kBox:
      return "box";
    case Part::Shape::kSphere:
      break;
  }
  return "sphere";
}

/// As wide as the thickest bone that meets there, so that the ball can be seen.
double jointRadius(const ArmModel& model, const Joint& joint) {
  constexpr double kSmallest = 0.01;  // [m]
  double radius = kSmallest;
  for (const int body : {joint.parent, joint.child}) {
    for (const Part& part : model.bodies[static_cast<std::size_t>(body)].parts) radius = std::max(radius, part.radius);
  }
  return radius;
}

std::string partsCsv(const ArmModel& model) {
  CsvWriter csv({"body", "part", "shape", "radius_m", "length_m", "size_x_m", "size_y_m", "size_z_m", "x_m", "y_m",
                 "z_m", "axis_x", "axis_y", "axis_z"});
  for (const Body& body : model.bodies) {
    for (const Part& part : body.parts) {
      csv.add(body.name).add(part.name.empty() ? body.name : part.name).add(shapeName(part.shape));
      csv.add(part.radius).add(part.length);
      add(csv, part.size);
      add(csv, part.position);
      add(csv, part.axis);
      csv.endRow();
    }
  }
  for (const Joint& joint : model.joints) {
    csv.add(model.bodies[static_cast<std::size_t>(joint.child)].name).add(joint.name).add("sphere");
    csv.add(jointRadius(model, joint)).add(0.0);
    add(csv, Eigen::Vector3d::Zero());
    add(csv, joint.child_position);
    add(csv, Eigen::Vector3d::UnitZ());
    csv.endRow();
  }
  return csv.text();
}

void addBodies(const ReplayedSet& replay, const std::string& pose, const char* state,
               const std::vector<BodyInWorld>& bodies, CsvWriter& csv) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Eigen::Quaterniond q(bodies[b].rotation);
    csv.add(replay.set).add(pose).add(state).add(replay.model.bodies[b].name);
    add(csv, bodies[b].origin);
    csv.add(q.w()).add(q.x()).add(q.y()).add(q.z()).endRow();
  }
}

/// The shortest line between two points round a sphere, both as vectors from its centre: from, points on the arc, to.
std::vector<Eigen::Vector3d> bentLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
  constexpr int kArcPoints = 7;
  const Eigen::Vector3d e = from.normalized();
  const Eigen::Vector3d across = (to - e * e.dot(to)).normalized();
  const double first = std::acos(radius / from.norm());
  const double last = std::atan2(across.dot(to), e.dot(to)) - std::acos(radius / to.norm());
  std::vector<Eigen::Vector3d> points{from};
  for (int k = 0; k < kArcPoints; ++k) {
    const double angle = first + (last - first) * k / (kArcPoints - 1);
    points.push_back(radius * (std::cos(angle) * e + std::sin(angle) * across));
  }
  points.push_back(to);
  return points;
}

/// The points a muscle's line runs through: its attachments and, where it wraps round a joint, the arc.
std::vector<Eigen::Vector3d> lineOf(const ArmModel& model, std::size_t m, const std::vector<BodyInWorld>& bodies) {
  const Muscle& muscle = model.muscles[m];
  std::vector<Eigen::Vector3d> points;
  for (const Attachment& a : muscle.attachments) points.push_back(bodies[static_cast<std::size_t>(a.body)] * a.point);
  for (const ArmExtension& extension : resolveExtensions(model)) {
    if (extension.effect->path == nullptr || !extension.on(static_cast<int>(m))) continue;
    const auto which = static_cast<std::size_t>(extension.p[1]) - 1;
    const Joint& joint = model.joints[static_cast<std::size_t>(jointsCrossed(model, muscle)[which])];
    const Eigen::Vector3d centre = bodies[static_cast<std::size_t>(joint.child)] * joint.child_position;
    BentPath bent;
    if (!extension.effect->path(extension.p, points.front() - centre, points.back() - centre, bent)) continue;
    points = bentLine(points.front() - centre, points.back() - centre, extension.p[0]);
    for (Eigen::Vector3d& point : points) point += centre;
    break;
  }
  return points;
}

/// At rest a cord pulls with its stiffness alone: T = k (L_S - L_SR).
void addMuscles(const ReplayedSet& replay, const std::string& pose, const PoseOutcome& outcome,
                const std::vector<BodyInWorld>& bodies, CsvWriter& csv) {
  for (std::size_t m = 0; m < replay.model.muscles.size(); ++m) {
    const Muscle& muscle = replay.model.muscles[m];
    const ShockCord& cord = muscle.shock_cord;
    const double tension = cord.force(cord.rest_length * (1.0 + outcome.cord_expansion[m]), 0.0);
    const std::vector<Eigen::Vector3d> line = lineOf(replay.model, m, bodies);
    for (std::size_t p = 0; p < line.size(); ++p) {
      csv.add(replay.set).add(pose).add(replay.state).add(muscle.name).add(static_cast<double>(p));
      add(csv, line[p]);
      csv.add(tension).endRow();
    }
  }
}

}  // namespace

void writeArmGeometry(std::span<const ReplayedSet> replays, const RunDirectory& directory) {
  CsvWriter bodies({"set", "pose", "state", "body", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"});
  CsvWriter muscles({"set", "pose", "state", "muscle", "point", "x_m", "y_m", "z_m", "tension_N"});
  for (std::size_t r = 0; r < replays.size(); ++r) {
    const ReplayedSet& replay = replays[r];
    const bool last_of_set = r + 1 == replays.size() || replays[r + 1].set != replay.set;
    for (std::size_t p = 0; p < replay.poses.poses.size(); ++p) {
      const Pose& pose = replay.poses.poses[p];
      if (last_of_set) addBodies(replay, pose.name, "measured", bodiesInWorld(replay.model, pose.joints), bodies);
      const PoseOutcome& outcome = replay.judged.outcomes[p];
      if (outcome.status != PoseStatus::kSteady) continue;
      const std::vector<BodyInWorld> placed = bodiesInWorld(replay.model, outcome.joints);
      addBodies(replay, pose.name, replay.state.c_str(), placed, bodies);
      addMuscles(replay, pose.name, outcome, placed, muscles);
    }
  }
  directory.write("arm_parts.csv", partsCsv(replays.back().model));
  directory.write("arm_bodies.csv", bodies.text());
  directory.write("arm_muscles.csv", muscles.text());
}

}  // namespace simgap
