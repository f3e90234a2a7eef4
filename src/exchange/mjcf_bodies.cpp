// <worldbody>: bodies, joints, sites, and the mass of geoms.
#include <fmt/format.h>

#include <numbers>

#include "mjcf_robot.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kMostBodies = 1000;
constexpr double kWaterDensity = 1000.0;  ///< [kg/m^3] MuJoCo's default

/// Sizes of a geom as MuJoCo stores them: radius and half lengths.
struct Geom {
  std::string type;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
};

Eigen::Isometry3d alongSegment(const MjcfNode& node, const std::vector<double>& ends, double& half_length) {
  if (ends.size() != 6) node.fail(fmt::format("fromto: found {} numbers, expected 6", ends.size()));
  const Eigen::Vector3d from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
  half_length = 0.5 * (to - from).norm();
  if (half_length < 1e-10) node.fail("fromto: found two equal points, expected a segment");
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), (to - from).normalized()).toRotationMatrix();
  frame.translation() = 0.5 * (from + to);
  return frame;
}

Geom readGeom(const MjcfNode& node) {
  Geom geom;
  // A shape that is fitted to a mesh has its size from there.
  geom.type = node.has("mesh") ? "mesh" : node.has("type") ? node.text("type") : "sphere";
  node.find("type");
  for (const MjcfNode& layer : node.layers()) {  // an own size may say only the first numbers
    const std::vector<double> size = layer.numbers("size");
    for (std::size_t i = 0; i < std::min<std::size_t>(size.size(), 3); ++i) geom.size[i] = size[i];
  }
  if (!node.has("fromto")) {
    geom.frame = node.frame();
  } else {
    for (const char* instead : {"pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"}) node.find(instead);
    double half = 0.0;
    geom.frame = alongSegment(node, node.numbers("fromto"), half);
    if (geom.type == "box" || geom.type == "ellipsoid") {
      geom.size = {geom.size.x(), geom.size.x(), half};
    } else {
      geom.size[1] = half;
    }
  }
  const std::map<std::string, int> sizes = {
      {"sphere", 1}, {"capsule", 2}, {"cylinder", 2}, {"ellipsoid", 3}, {"box", 3}};
  if (const auto needed = sizes.find(geom.type); needed != sizes.end()) {
    for (int i = 0; i < needed->second; ++i) {
      if (geom.size[i] <= 0.0) node.fail(fmt::format("size: found {} of a {}, expected > 0", geom.size[i], geom.type));
    }
  } else if (geom.type != "plane" && geom.type != "hfield" && geom.type != "mesh" && geom.type != "sdf") {
    node.fail(fmt::format("type: found '{}', expected one of MuJoCo's", abridged(geom.type)));
  }
  return geom;
}

/// Where a joint's stops hold: `margin` before the ends of its range, in rad for a hinge whatever the file's unit is.
std::array<double, 2> stopsOf(const MjcfNode& joint, double lower, double upper) {
  const double margin = joint.number("margin", 0.0);
  if (margin == 0.0) return {lower, upper};
  if (lower + margin >= upper - margin) {
    joint.remark("margin", "left out: both stops hold at once there, half the range is no wider than it");
    return {lower, upper};
  }
  joint.remark("margin", "taken off both ends of the range, where MuJoCo's stops hold", false);
  return {lower + margin, upper - margin};
}

/// Volume of the shape [m^3], and its inertia per mass [m^2], about its centre along its axes.
std::pair<double, Eigen::Vector3d> solid(const Geom& geom) {
  const double r = geom.size.x(), length = 2.0 * geom.size.y();
  const Eigen::Vector3d squares = geom.size.cwiseAbs2();
  const Eigen::Vector3d others(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y());
  const double pi = std::numbers::pi;
  if (geom.type == "sphere") return {4.0 / 3.0 * pi * r * r * r, Eigen::Vector3d::Constant(0.4 * r * r)};
  if (geom.type == "box") return {8.0 * geom.size.prod(), others / 3.0};
  if (geom.type == "ellipsoid") return {4.0 / 3.0 * pi * geom.size.prod(), others / 5.0};
  const double across = (3.0 * r * r + length * length) / 12.0, along = 0.5 * r * r;
  if (geom.type == "cylinder") return {pi * r * r * length, {across, across, along}};
  // Capsule: a cylinder and two halves of a sphere at its ends.
  const double caps = 4.0 * r / (4.0 * r + 3.0 * length);  // of the mass
  const double sphere = 0.4 * r * r;
  const double far = sphere + length * (3.0 * r + 2.0 * length) / 8.0;
  const double both = (1.0 - caps) * across + caps * far;
  return {pi * r * r * (length + 4.0 / 3.0 * r), {both, both, (1.0 - caps) * along + caps * sphere}};
}

class Bodies {
 public:
  Bodies(MjcfFile& file, MjcfRobot& robot) : file_(file), robot_(robot) {}

  void readWorld(const MjcfNode& world) { readContent(world, -1, Eigen::Isometry3d::Identity()); }

  /// What can only be said once all is read.
  void finish() {
    const bool hangs = std::ranges::any_of(robot_.bodies, [](const MjcfBody& body) { return !body.joints.empty(); });
    if (!hangs && !floating_.empty()) refuseFloating(floating_.front());
    if (!hangs && unread_) {
      unread_->fail(
          "found it, which is not read, and no joint outside of it, expected the bodies themselves: MuJoCo's `compile` "
          "writes them");
    }
    for (const auto& [body, node] : meshes_) {
      const bool needed = body >= 0 && !given_inertia_[body];
      if (needed) refuseGuess(body, node);
      node.remarkAll("mesh geom",
                     fmt::format("left out: meshes are not read; {}",
                                 needed ? "its mass needs <inertial>" : "its body's mass does not ask for it"),
                     needed);
    }
  }

 private:
  /// What stands in a body, or in a <frame> of it. \param offset  of the frame in the body
  void readContent(const MjcfNode& node, int body, const Eigen::Isometry3d& offset) {
    if (++depth_ > kDeepestMjcf) refuseDeep(node);
    for (const MjcfNode& child : node.children()) {
      const std::string tag = child.tag();
      if (tag == "body") {
        readBody(child, body, offset);
      } else if (tag == "frame") {
        child.find("name");
        readContent(child, body, offset * child.frame());
      } else if (tag == "joint" || tag == "freejoint") {
        readJoint(child, body, offset);
      } else if (tag == "geom") {
        readMass(child, body, offset);
      } else if (tag == "site") {
        readSite(child, body, offset);
      } else if (tag == "inertial") {
        if (body >= 0) readInertial(child, body, offset);
      } else if (tag == "light" || tag == "camera") {
        child.remarkAll(tag, "looks: left out", false);
      } else {
        if (!unread_) unread_ = child;
        child.remarkAll(tag, "not understood, left out with all that stands in it");
      }
    }
    --depth_;
  }

  /// The compiler would hide behind its own numbers that a mass is not known.
  void refuseGuess(int body, const MjcfNode& mesh) const {
    if (file_.compiler().total_mass > 0.0) {
      mesh.fail(
          "found a mesh, which is not read, where the compiler's settotalmass scales all masses; expected "
          "<inertial> in its body");
    }
    if (robot_.bodies[body].mass.mass < file_.compiler().least_mass && carrierOf(robot_, body) >= 0) {
      mesh.fail(
          "found a mesh, which is not read, so that its body would weigh the compiler's boundmass; expected "
          "<inertial> in it");
    }
  }

  [[noreturn]] static void refuseFloating(const MjcfNode& joint) {
    joint.fail("found a floating base, expected bodies that hang on the world by joints");
  }

  [[noreturn]] static void refuseDeep(const MjcfNode& node) {
    node.fail(fmt::format("found bodies nested deeper than {}", kDeepestMjcf));
  }

  static bool isFree(const MjcfNode& joint) {
    return joint.tag() == "freejoint" || (joint.tag() == "joint" && joint.text("type") == "free");
  }

  /// The free joint of a body itself, or one of the joints in a body.
  static std::optional<MjcfNode> findJoint(const MjcfNode& node, bool free, int depth = 0) {
    if (depth > kDeepestMjcf) refuseDeep(node);
    for (const MjcfNode& child : node.children()) {
      const std::string tag = child.tag();
      if ((tag == "joint" || tag == "freejoint") && isFree(child) == free) return child;
      if (tag != "frame" && (free || tag != "body")) continue;
      if (std::optional<MjcfNode> inner = findJoint(child, free, depth + 1)) return inner;
    }
    return std::nullopt;
  }

  void nameLoose(const MjcfNode& node, int depth = 0) {
    if (depth > kDeepestMjcf) refuseDeep(node);
    const std::string kind = node.tag() == "freejoint" ? "joint" : node.tag();
    if (node.has("name")) robot_.loose.insert(kind + " " + node.text("name"));
    for (const MjcfNode& child : node.children()) nameLoose(child, depth + 1);
  }

  static bool holdsGeomThatTouches(const MjcfNode& node) {
    if (node.tag() == "geom") return node.number("contype", 1.0) != 0.0 || node.number("conaffinity", 1.0) != 0.0;
    const std::vector<MjcfNode> inner = node.children();
    return std::ranges::any_of(inner, holdsGeomThatTouches);
  }

  /// A loose thing beside the robot touches nothing here. \returns whether the body was one
  bool leaveOutLoose(const MjcfNode& node) {
    const std::optional<MjcfNode> free = findJoint(node, true);
    if (!free) return false;
    if (findJoint(node, false)) refuseFloating(*free);
    floating_.push_back(*free);
    nameLoose(node);
    // A loose thing that can touch may lie in a hand.
    const bool meets = robot_.contacts && holdsGeomThatTouches(node);
    node.remarkAll("body with a free joint", "a loose thing: left out with all that stands in it", meets);
    return true;
  }

  void readBody(const MjcfNode& node, int parent, const Eigen::Isometry3d& offset) {
    if (parent < 0 && leaveOutLoose(node)) return;
    if (robot_.bodies.size() >= kMostBodies) node.fail(fmt::format("found more than {} bodies", kMostBodies));
    const int index = static_cast<int>(robot_.bodies.size());
    MjcfBody& body = robot_.bodies.emplace_back();
    body.said = node.newName("body");
    body.parent = parent;
    body.frame = offset * node.frame();
    body.place = file_.xml().place(node.xml());
    if (node.flag("mocap", false)) node.remark("mocap", "a body that moves by data stands still here");
    if (node.number("gravcomp", 0.0) != 0.0) node.remark("gravcomp", "left out: gravity acts on every body");
    given_inertia_.push_back(false);
    readContent(node, index, Eigen::Isometry3d::Identity());
  }

  void readJoint(const MjcfNode& node, int body, const Eigen::Isometry3d& offset) {
    if (body < 0) node.fail("found a joint of the world, expected it in a body");
    if (isFree(node)) refuseFloating(node);
    const std::string type = node.has("type") ? node.text("type") : "hinge";
    MjcfJoint joint;
    joint.kind = findKind(&JointKind::mjcf, type);
    if (joint.kind == nullptr)
      node.fail(fmt::format("type: found '{}', expected hinge, ball or slide", abridged(type)));
    joint.said = node.newName("joint");
    joint.place = file_.xml().place(node.xml());
    joint.position = offset * node.vector3("pos", Eigen::Vector3d::Zero());
    const Eigen::Vector3d axis = node.vector3("axis", Eigen::Vector3d::UnitZ());
    if (axis.norm() < 1e-10) node.fail("axis: found a zero vector, expected an axis");
    joint.axis = offset.linear() * axis.normalized();
    readJointLaw(node, joint);
    robot_.bodies[body].joints.push_back(joint);
  }

  void readJointLaw(const MjcfNode& node, MjcfJoint& joint) {
    const double unit = joint.kind->unit == "m" ? 1.0 : node.angleUnit();
    const bool ball = !joint.kind->has_axis;
    joint.reference = ball ? 0.0 : unit * node.number("ref", 0.0);
    if (joint.reference != 0.0) {
      node.remark("ref", "positions count from the drawn pose: MuJoCo's position less ref");
    }
    if (const auto range = node.limits("limited", "range")) {
      const std::array<double, 2> stops = stopsOf(node, unit * (*range)[0], unit * (*range)[1]);
      joint.range = {stops[0] - joint.reference, stops[1] - joint.reference};
    }
    node.find("margin");
    joint.stiffness = node.nonNegative("stiffness", 0.0);
    joint.spring_reference = ball ? 0.0 : unit * node.number("springref", 0.0) - joint.reference;
    joint.damping = node.nonNegative("damping", 0.0);
    joint.friction_loss = node.nonNegative("frictionloss", 0.0);
    if (ball && joint.friction_loss > 0.0) {
      node.remark("frictionloss", "of a ball: about each of three axes in MuJoCo, a vector of that length here");
    }
    joint.armature = node.number("armature", 0.0);
    if (joint.armature != 0.0) {
      node.remark("armature", "left out: a joint has no rotor (motions only, not where the robot rests)");
    }
    if (const std::vector<double> said = node.numbers("springdamper"); !said.empty()) {
      if (said.size() != 2) node.fail(fmt::format("springdamper: found {} numbers, expected two", said.size()));
      joint.spring_damper = {said[0], said[1]};
      if (joint.springDamped()) {
        node.remark("springdamper", "worked out as stiffness and damping, as in MuJoCo", false);
      }
    }
    if (node.has("actuatorfrcrange")) node.remark("actuatorfrcrange", "left out: no limit of a joint's torque");
  }

  void readMass(const MjcfNode& node, int body, const Eigen::Isometry3d& offset) {
    Geom geom = readGeom(node);
    geom.frame = offset * geom.frame;
    const std::string name = node.newName("geom");
    if (!name.empty() && (geom.type == "sphere" || geom.type == "cylinder")) {
      robot_.surfaces[name] = {"",         file_.xml().place(node.xml()), body,
                               geom.frame, geom.type == "cylinder",       geom.size.x()};
    }
    const auto bits = [&](const char* attribute) { return static_cast<std::int64_t>(node.number(attribute, 1.0)); };
    robot_.geoms.push_back({name, body, bits("contype"), bits("conaffinity"), file_.xml().place(node.xml())});
    const std::vector<double>& groups = file_.compiler().inertia_groups;
    const double group = node.number("group", 0.0);
    const double density = node.nonNegative("density", kWaterDensity);
    const double stated = node.nonNegative("mass", -0.0);
    const bool mesh = geom.type == "mesh" || geom.type == "sdf";
    const bool counts = group >= groups[0] && group <= groups[1] && file_.compiler().inertia_from_geom != "false";
    if (mesh) meshes_.emplace_back(counts && (node.has("mass") ? stated : density) > 0.0 ? body : -1, node);
    if (mesh || !counts || body < 0 || geom.type == "plane" || geom.type == "hfield") return;
    if (node.has("shellinertia") && node.flag("shellinertia", false)) {
      node.remark("shellinertia", "the shape is taken as solid");
    }
    const auto [volume, per_mass] = solid(geom);
    MassProperties mass;
    mass.mass = node.has("mass") ? stated : density * volume;
    mass.inertia = (mass.mass * per_mass).asDiagonal();
    MjcfBody& owner = robot_.bodies[body];
    if (given_inertia_[body]) return;
    owner.mass = addMass(owner.mass, inFrame(mass, geom.frame));
  }

  /// <inertial> replaces what geoms would give, before or behind it.
  void readInertial(const MjcfNode& node, int body, const Eigen::Isometry3d& offset) {
    MassProperties mass;
    mass.mass = node.nonNegative("mass", 0.0);
    const std::vector<double> full = node.numbers("fullinertia");
    if (!full.empty() && full.size() != 6)
      node.fail(fmt::format("fullinertia: found {} numbers, expected 6", full.size()));
    if (!full.empty()) {
      mass.inertia << full[0], full[3], full[4], full[3], full[1], full[5], full[4], full[5], full[2];
    } else {
      mass.inertia = node.vector3("diaginertia", Eigen::Vector3d::Zero()).asDiagonal();
    }
    if (file_.compiler().inertia_from_geom == "true") {
      return node.remarkAll("inertial", "left out: compiler inertiafromgeom", false);
    }
    given_inertia_[body] = true;
    robot_.bodies[body].mass = inFrame(mass, offset * node.frame());
  }

  void readSite(const MjcfNode& node, int body, const Eigen::Isometry3d& offset) {
    for (const char* looks : {"type", "size"}) node.find(looks);
    const bool segment = node.has("fromto");
    double half = 0.0;
    const Eigen::Isometry3d frame = segment ? alongSegment(node, node.numbers("fromto"), half) : node.frame();
    const std::string name = node.newName("site");
    if (!name.empty()) robot_.sites[name] = {body, offset * frame.translation()};
  }

  MjcfFile& file_;
  MjcfRobot& robot_;
  std::vector<bool> given_inertia_;
  std::vector<MjcfNode> floating_;                ///< free joints of what is left out
  std::optional<MjcfNode> unread_;                ///< the first element that is not understood
  std::vector<std::pair<int, MjcfNode>> meshes_;  ///< with their bodies; -1: weighs nothing that moves
  int depth_ = 0;
};

}  // namespace

void readMjcfBodies(MjcfFile& file, MjcfRobot& robot) {
  Bodies bodies(file, robot);
  for (const MjcfNode& world : file.sections("worldbody")) bodies.readWorld(world);
  bodies.finish();
  workOutMasses(file.compiler(), robot);
}

}  // namespace simgap
