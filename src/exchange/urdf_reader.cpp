// URDF: links and joints. Muscles are no part of the format.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "arm_exchange.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/text.h"
#include "xml_robot.h"

namespace simgap {
namespace {

constexpr std::size_t kMostLinks = 1000;

const std::map<std::string, std::string> kIgnoredInUrdf = {
    {"visual", "looks: left out"},
    {"material", "looks: left out"},
    {"collision", "contacts are not modelled: left out"},
    {"gazebo", "for a simulator: left out"},
    {"transmission", "for a controller: left out"},
    {"safety_controller", "for a controller: left out"},
    {"calibration", "for a controller: left out"},
    {"ros2_control", "for a controller: left out"},
    {"@effort", "left out: no limit of a joint's torque"},
    {"@velocity", "left out: no limit of a joint's velocity"},
    {"@version", "the file's version: left out"},
    {"@xmlns:xacro", "a name space: left out"},
};

struct UrdfJoint {
  Joint joint;
  std::string type, parent, child, mimic;
  double multiplier = 1.0, offset = 0.0;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  ///< of the child in the parent
  std::string place;
};

class UrdfArm {
 public:
  UrdfArm(const std::string& text, const std::filesystem::path& file)
      : file_(file), root_(&xml_.parse(text, file, {"robot"})) {}

  ImportedArm read() {
    const char* const name = xml_.find(*root_, "name");
    arm_.name = name == nullptr || *name == '\0' ? "robot" : name;
    for (const auto* e = root_->FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string_view tag = e->Name();
      if (tag == "link") readLink(*e);
      if (tag == "joint") readJoint(*e);
    }
    const std::string base = baseLink();
    arm_.bodies.push_back({.name = freeName(base, body_names_), .fixed = true, .parts = {}, .surfaces = {}});
    places_[base] = {0, Eigen::Isometry3d::Identity()};
    attachChildren(base);
    if (arm_.joints.empty()) fail("found no joint that moves, expected at least one");
    for (const UrdfJoint& joint : joints_) follow(joint);
    std::vector<ExchangeRemark> remarks = xml_.finish(kIgnoredInUrdf);
    return {checkedArm(std::move(arm_), file_), std::move(remarks)};
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const {
    throw DataError(fmt::format("{}: {}", file_.filename().string(), sentence));
  }

  const XmlElement* child(const XmlElement& element, const char* name) {
    const XmlElement* const found = element.FirstChildElement(name);
    if (found != nullptr) xml_.understand(*found);
    return found;
  }

  std::string required(const XmlElement& element, const char* attribute) {
    const char* const value = xml_.find(element, attribute);
    if (value == nullptr || *value == '\0') xml_.fail(element, fmt::format("found no {}, expected one", attribute));
    return value;
  }

  double number(const XmlElement& element, const char* attribute, double fallback) {
    const char* const value = xml_.find(element, attribute);
    return value == nullptr ? fallback : xml_.number(element, attribute, value);
  }

  Eigen::Isometry3d origin(const XmlElement& element) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    const XmlElement* const at = child(element, "origin");
    if (at == nullptr) return frame;
    if (const char* xyz = xml_.find(*at, "xyz")) frame.translation() = xml_.vector3(*at, "xyz", xyz);
    if (const char* rpy = xml_.find(*at, "rpy")) {
      const Eigen::Vector3d a = xml_.vector3(*at, "rpy", rpy);
      frame.linear() =
          (Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()))
              .toRotationMatrix();
    }
    return frame;
  }

  void readLink(const XmlElement& element) {
    xml_.understand(element);
    const std::string name = required(element, "name");
    if (links_.size() >= kMostLinks) xml_.fail(element, fmt::format("found more than {} links", kMostLinks));
    const XmlElement* const inertial = child(element, "inertial");
    MassProperties mass;
    if (inertial != nullptr) mass = readInertial(*inertial);
    if (!links_.emplace(name, mass).second) xml_.fail(element, fmt::format("the name '{}' is taken", abridged(name)));
    order_.push_back(name);
  }

  MassProperties readInertial(const XmlElement& element) {
    MassProperties mass;
    const Eigen::Isometry3d frame = origin(element);
    const XmlElement* const weight = child(element, "mass");
    if (weight == nullptr) xml_.fail(element, "found no mass, expected one");
    mass.mass = xml_.number(*weight, "value", required(*weight, "value").c_str());
    if (mass.mass < 0.0) xml_.fail(*weight, fmt::format("value: found {}, expected >= 0", mass.mass));
    if (const XmlElement* const i = child(element, "inertia")) {
      const auto entry = [&](const char* name) { return number(*i, name, 0.0); };
      // Read before the matrix is filled: Eigen allows no exception in between.
      const double xx = entry("ixx"), yy = entry("iyy"), zz = entry("izz");
      const double xy = entry("ixy"), xz = entry("ixz"), yz = entry("iyz");
      mass.inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    }
    mass.centre_of_mass = frame.translation();
    mass.inertia = (frame.linear() * mass.inertia * frame.linear().transpose()).eval();
    return mass;
  }

  void readJoint(const XmlElement& element) {
    xml_.understand(element);
    UrdfJoint joint;
    joint.place = xml_.place(element);
    joint.joint.name = freeName(required(element, "name"), joint_names_);
    joint.type = required(element, "type");
    if (joint.type == "floating" || joint.type == "planar") {
      xml_.fail(element, fmt::format("type: found '{}', expected a joint of one axis or none", joint.type));
    }
    if (joint.type != "revolute" && joint.type != "continuous" && joint.type != "prismatic" && joint.type != "fixed") {
      xml_.fail(element, fmt::format("type: found '{}', expected revolute, continuous, prismatic or fixed",
                                     abridged(joint.type)));
    }
    joint.parent = linkOf(element, "parent");
    joint.child = linkOf(element, "child");
    joint.frame = origin(element);
    readMotion(element, joint);
    joints_.push_back(joint);
  }

  void readMotion(const XmlElement& element, UrdfJoint& joint) {
    Joint& j = joint.joint;
    const JointKind* const kind = findKind(&JointKind::urdf, joint.type);
    j.type = (kind != nullptr ? kind : findKind(&JointKind::urdf, "revolute"))
                 ->type;  // a continuous one, and what is welded
    j.axis = Eigen::Vector3d::UnitX();
    if (const XmlElement* const axis = child(element, "axis")) {
      j.axis = xml_.vector3(*axis, "xyz", required(*axis, "xyz").c_str());
      if (j.axis.norm() < 1e-9 && joint.type != "fixed") xml_.fail(*axis, "xyz: found a zero vector, expected an axis");
      if (std::abs(j.axis.norm() - 1.0) > 1e-12 && j.axis.norm() > 0.0) j.axis.normalize();
    }
    if (const XmlElement* const limit = child(element, "limit"); limit && joint.type != "continuous") {
      j.lower_limit = number(*limit, "lower", 0.0);
      j.upper_limit = number(*limit, "upper", 0.0);
      if (j.lower_limit > j.upper_limit) {
        xml_.fail(*limit, fmt::format("found lower {} above upper {}", j.lower_limit, j.upper_limit));
      }
    }
    if (const XmlElement* const dynamics = child(element, "dynamics")) {
      j.viscous_friction = number(*dynamics, "damping", 0.0);
      j.coulomb_friction = number(*dynamics, "friction", 0.0);
      if (j.viscous_friction < 0.0 || j.coulomb_friction < 0.0) xml_.fail(*dynamics, "found a number < 0");
    }
    if (const XmlElement* const mimic = child(element, "mimic")) {
      joint.mimic = required(*mimic, "joint");
      joint.multiplier = number(*mimic, "multiplier", 1.0);
      joint.offset = number(*mimic, "offset", 0.0);
    }
  }

  std::string linkOf(const XmlElement& element, const char* role) {
    const XmlElement* const end = child(element, role);
    if (end == nullptr) xml_.fail(element, fmt::format("found no {}, expected a link", role));
    return required(*end, "link");
  }

  /// The one link that no joint moves.
  std::string baseLink() const {
    std::map<std::string, int> parents;
    for (const UrdfJoint& joint : joints_) {
      for (const std::string& link : {joint.parent, joint.child}) {
        if (!links_.contains(link)) {
          throw DataError(fmt::format("{}: found '{}', expected the name of a link", joint.place, abridged(link)));
        }
      }
      if (++parents[joint.child] > 1) {
        throw DataError(fmt::format("{}: link '{}' is the child of two joints, expected a tree", joint.place,
                                    abridged(joint.child)));
      }
    }
    std::vector<std::string> roots;
    for (const std::string& link : order_) {
      if (!parents.contains(link)) roots.push_back(link);
    }
    if (roots.size() != 1) {
      fail(fmt::format("found {} links that hang on no other{}, expected one", roots.size(),
                       roots.empty() ? " (the joints run in a circle)" : ""));
    }
    return roots[0];
  }

  /// Joints outwards from a link, in the order of the file; what is fixed becomes a part.
  void attachChildren(const std::string& link) {
    for (UrdfJoint& joint : joints_) {
      if (joint.parent != link) continue;
      const auto [body, frame] = places_.at(link);
      const Eigen::Isometry3d in_body = frame * joint.frame;
      const MassProperties& mass = links_.at(joint.child);
      if (joint.type == "fixed") {
        places_[joint.child] = {body, in_body};
        Body& carrier = arm_.bodies[body];
        xml_.add(fmt::format("link '{}'", abridged(joint.child)),
                 fmt::format("fixed: a part of '{}'", abridged(carrier.name)), false, joint.place);
        if (!carrier.fixed && mass.mass > 0.0) {
          MassProperties moved{mass.mass, in_body * mass.centre_of_mass, {}};
          moved.inertia = in_body.linear() * mass.inertia * in_body.linear().transpose();
          carrier.parts.push_back(statedPart(freePartName(carrier, freeName(joint.child, body_names_)), moved));
        }
      } else {
        joint.joint.parent = body;
        joint.joint.child = static_cast<int>(arm_.bodies.size());
        joint.joint.parent_position = in_body.translation();
        joint.joint.parent_orientation = tidyRotation(in_body.linear());
        places_[joint.child] = {joint.joint.child, Eigen::Isometry3d::Identity()};
        Body& moved = arm_.bodies.emplace_back();
        moved.name = freeName(joint.child, body_names_);
        if (mass.mass > 0.0) moved.parts.push_back(statedPart(moved.name, mass));
        arm_.joints.push_back(joint.joint);
      }
      attachChildren(joint.child);
    }
  }

  void follow(const UrdfJoint& joint) {
    if (joint.mimic.empty()) return;
    const auto index = [&](const std::string& name) {
      const auto found = std::ranges::find(arm_.joints, name, &Joint::name);
      if (found == arm_.joints.end()) {
        throw DataError(
            fmt::format("{}: mimic: found '{}', expected the name of a joint that moves", joint.place, abridged(name)));
      }
      return static_cast<int>(found - arm_.joints.begin());
    };
    tieJoints(arm_, index(joint.joint.name), index(joint.mimic), joint.multiplier, joint.offset, joint.place);
  }

  XmlRobot xml_;
  std::filesystem::path file_;
  const XmlElement* root_;
  ArmModel arm_;
  std::map<std::string, MassProperties> links_;
  std::vector<std::string> order_;
  std::vector<UrdfJoint> joints_;
  std::set<std::string> joint_names_, body_names_;
  std::map<std::string, std::pair<int, Eigen::Isometry3d>> places_;  ///< of a link, in a body of the arm
};

}  // namespace

ImportedArm readUrdf(const std::string& text, const std::filesystem::path& file) { return UrdfArm(text, file).read(); }

}  // namespace simgap
