#include "simgap/simulate/arm_geometry.h"

#include <algorithm>

#include "simgap/core/csv.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/muscle_line.h"

namespace simgap {
namespace {

void add(CsvWriter& csv, const Eigen::Vector3d& v) { csv.add(v.x()).add(v.y()).add(v.z()); }

const char* shapeName(Part::Shape shape) {
  switch (shape) {
    case Part::Shape::kCylinder:
    case Part::Shape::kCapsule:
      return "cylinder";
    case Part::Shape::kBox:
      return "box";
    case Part::Shape::kSphere:
    case Part::Shape::kEllipsoid:
    case Part::Shape::kInertia:
      break;
  }
  return "sphere";
}

/// Of the ball that stands for a part: an ellipsoid's mean semi-axis, and of a stated inertia a mark.
double drawnRadius(const Part& part) {
  constexpr double kMark = 0.005;  // [m]
  if (part.shape == Part::Shape::kEllipsoid) return part.size.mean();
  return part.shape == Part::Shape::kInertia ? kMark : part.radius;
}

/// As wide as the thickest bone that meets there, so that the ball can be seen.
double jointRadius(const ArmModel& model, const Joint& joint) {
  constexpr double kSmallest = 0.01;  // [m]
  double radius = kSmallest;
  for (const int body : {joint.parent, joint.child}) {
    for (const Part& part : model.bodies[body].parts) radius = std::max(radius, part.radius);
  }
  return radius;
}

std::string partsCsv(const ArmModel& model) {
  CsvWriter csv({"body", "part", "shape", "radius_m", "length_m", "size_x_m", "size_y_m", "size_z_m", "x_m", "y_m",
                 "z_m", "axis_x", "axis_y", "axis_z"});
  for (const Body& body : model.bodies) {
    for (const Part& part : body.parts) {
      csv.add(body.name).add(part.name.empty() ? body.name : part.name).add(shapeName(part.shape));
      csv.add(drawnRadius(part)).add(part.length);
      add(csv, part.size);
      add(csv, part.position);
      add(csv, part.axis);
      csv.endRow();
    }
  }
  for (const Joint& joint : model.joints) {
    csv.add(model.bodies[joint.child].name).add(joint.name).add("sphere");
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

void addLine(const ReplayedSet& replay, const std::string& pose, const std::string& name,
             const std::vector<Eigen::Vector3d>& line, double tension, CsvWriter& csv) {
  for (std::size_t p = 0; p < line.size(); ++p) {
    csv.add(replay.set).add(pose).add(replay.state).add(name).add(static_cast<double>(p));
    add(csv, line[p]);
    csv.add(tension).endRow();
  }
}

/// At rest a cord pulls with its stiffness, T = k (L_S - L_SR), and with what extensions add to that. [N]
double tensionOf(const ArmModel& model, const std::vector<ArmExtension>& extensions, std::size_t m, const Pose& pose,
                 const PoseOutcome& outcome) {
  const Muscle& muscle = model.muscles[m];
  const ShockCord& cord = muscle.shock_cord;
  const double expansion = cord.rest_length * outcome.cord_expansion[m], shaft = outcome.shafts[m];
  double tension = cord.force(cord.rest_length + expansion, 0.0);
  const LineState line{shaft, muscle.spindle_radius, pose.time,
                       pose.shafts_before.empty() ? 0.0 : pose.shafts_before[m],
                       muscle.kite_line_length - muscle.spindle_radius * shaft};
  for (const ArmExtension& extension : extensions) {
    if (expansion <= 0.0 || !extension.effect->cord || !extension.on(static_cast<int>(m))) continue;
    tension += extension.effect->cord(extension.p, expansion, cord, line).force;
  }
  return tension;
}

void addMuscles(const ReplayedSet& replay, const Pose& recorded, const PoseOutcome& outcome,
                const std::vector<BodyInWorld>& bodies, CsvWriter& csv) {
  const std::string& pose = recorded.name;
  const std::vector<ArmExtension> extensions = resolveExtensions(replay.model);
  for (std::size_t m = 0; m < replay.model.muscles.size(); ++m) {
    addLine(replay, pose, replay.model.muscles[m].name, muscleLine(replay.model, m, bodies),
            tensionOf(replay.model, extensions, m, recorded, outcome), csv);
  }
  std::size_t command = replay.model.muscles.size();
  for (const PassiveTendon& tendon : replay.model.tendons) {
    if (!tendon.kind->command) continue;
    const double told = outcome.shafts[command++];
    if (tendon.kind->at_joint) continue;
    const double length = tendonLength(replay.model, tendon, bodies, outcome.joints);
    const double tension = tendon.kind->pull(tendon.p, length, told).force;
    std::vector<Eigen::Vector3d> line;  // branches one after the other
    for (const auto& branch : tendonPoints(replay.model, tendon, bodies))
      line.insert(line.end(), branch.begin(), branch.end());
    addLine(replay, pose, tendon.name, line, tension, csv);
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
      const PoseOutcome& outcome = replay.outcomes[p];
      if (outcome.status != PoseStatus::kSteady) continue;
      const std::vector<BodyInWorld> placed = bodiesInWorld(replay.model, outcome.joints);
      addBodies(replay, pose.name, replay.state.c_str(), placed, bodies);
      addMuscles(replay, pose, outcome, placed, muscles);
    }
  }
  directory.write("arm_parts.csv", partsCsv(replays.back().model));
  directory.write("arm_bodies.csv", bodies.text());
  directory.write("arm_muscles.csv", muscles.text());
}

}  // namespace simgap
