// URDF: links and joints. Muscles are no part of the format.
#include <fmt/format.h>

#include <map>

#include "arm_exchange.h"
#include "link_tree.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

const std::map<std::string, std::string> kIgnoredInUrdf = {
    {"visual", "looks: left out"},
    {"material", "looks: left out"},
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

class UrdfArm {
 public:
  UrdfArm(const std::string& text, const std::filesystem::path& file)
      : file_(file), root_(&xml_.parse(text, file, {"robot"})) {}

  ImportedArm read() {
    xml_.refuseMacros(*root_);
    const char* const name = xml_.find(*root_, "name");
    arm_.name = name == nullptr || *name == '\0' ? "robot" : name;
    for (const auto* e = root_->FirstChildElement(); e; e = e->NextSiblingElement()) {
      const std::string_view tag = e->Name();
      if (tag == "link") readLink(*e);
      if (tag == "joint") readJoint(*e);
    }
    arm_ = tree_.build(std::move(arm_));
    std::vector<ExchangeRemark> remarks = xml_.finish(kIgnoredInUrdf);
    return {checkedArm(std::move(arm_), file_, tree_.places()), std::move(remarks)};
  }

 private:
  double number(const XmlElement& element, const char* attribute, double fallback) {
    const char* const value = xml_.find(element, attribute);
    return value == nullptr ? fallback : xml_.number(element, attribute, value);
  }

  Eigen::Isometry3d origin(const XmlElement& element) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    const XmlElement* const at = xml_.child(element, "origin");
    if (at == nullptr) return frame;
    if (const char* xyz = xml_.find(*at, "xyz")) frame.translation() = xml_.vector3(*at, "xyz", xyz);
    if (const char* rpy = xml_.find(*at, "rpy")) {
      frame.linear() = fromRollPitchYaw(xml_.vector3(*at, "rpy", rpy)).toRotationMatrix();
    }
    return frame;
  }

  void readLink(const XmlElement& element) {
    xml_.understand(element);
    const std::string name = xml_.required(element, "name");
    const XmlElement* const inertial = xml_.child(element, "inertial");
    tree_.addLink(element, name, inertial == nullptr ? MassProperties{} : readInertial(*inertial));
  }

  MassProperties readInertial(const XmlElement& element) {
    MassProperties mass;
    const Eigen::Isometry3d frame = origin(element);
    const XmlElement* const weight = xml_.child(element, "mass");
    if (weight == nullptr) xml_.fail(element, "found no mass, expected one");
    mass.mass = xml_.number(*weight, "value", xml_.required(*weight, "value").c_str());
    if (mass.mass < 0.0) xml_.fail(*weight, fmt::format("value: found {}, expected >= 0", mass.mass));
    if (const XmlElement* const i = xml_.child(element, "inertia")) {
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
    LinkJoint joint;
    joint.place = xml_.place(element);
    const std::string name = xml_.required(element, "name"), type = xml_.required(element, "type");
    if (type == "floating" || type == "planar") {
      xml_.fail(element, fmt::format("type: found '{}', expected a joint of one axis or none", type));
    }
    if (type != "revolute" && type != "continuous" && type != "prismatic" && type != "fixed") {
      xml_.fail(element,
                fmt::format("type: found '{}', expected revolute, continuous, prismatic or fixed", abridged(type)));
    }
    joint.fixed = type == "fixed";
    joint.parent = linkOf(element, "parent");
    joint.child = linkOf(element, "child");
    joint.in_parent = origin(element);
    readMotion(element, type, joint);
    tree_.addJoint(joint, name);
  }

  void readMotion(const XmlElement& element, const std::string& type, LinkJoint& joint) {
    Joint& j = joint.joint;
    const JointKind* const kind = findKind(&JointKind::urdf, type);
    j.type = (kind != nullptr ? kind : findKind(&JointKind::urdf, "revolute"))
                 ->type;  // a continuous one, and what is welded
    j.axis = Eigen::Vector3d::UnitX();
    if (const XmlElement* const axis = xml_.child(element, "axis")) {
      j.axis = xml_.vector3(*axis, "xyz", xml_.required(*axis, "xyz").c_str());
      if (j.axis.norm() < 1e-9 && !joint.fixed) xml_.fail(*axis, "xyz: found a zero vector, expected an axis");
      if (std::abs(j.axis.norm() - 1.0) > 1e-12 && j.axis.norm() > 0.0) j.axis.normalize();
    }
    const XmlElement* const limit = xml_.child(element, "limit");
    if (limit == nullptr && (type == "revolute" || type == "prismatic")) {
      xml_.add(fmt::format("{} joint without limit", type), "has none here, though the format asks for one", true,
               joint.place);
    }
    if (limit != nullptr && type != "continuous") {
      j.lower_limit = number(*limit, "lower", 0.0);
      j.upper_limit = number(*limit, "upper", 0.0);
      if (j.lower_limit > j.upper_limit) {
        xml_.fail(*limit, fmt::format("found lower {} above upper {}", j.lower_limit, j.upper_limit));
      }
    }
    if (const XmlElement* const dynamics = xml_.child(element, "dynamics")) {
      j.viscous_friction = number(*dynamics, "damping", 0.0);
      j.coulomb_friction = number(*dynamics, "friction", 0.0);
      if (j.viscous_friction < 0.0 || j.coulomb_friction < 0.0) xml_.fail(*dynamics, "found a number < 0");
    }
    if (const XmlElement* const mimic = xml_.child(element, "mimic")) {
      joint.leader = xml_.required(*mimic, "joint");
      joint.multiplier = number(*mimic, "multiplier", 1.0);
      joint.offset = number(*mimic, "offset", 0.0);
    }
  }

  std::string linkOf(const XmlElement& element, const char* role) {
    const XmlElement* const end = xml_.child(element, role);
    if (end == nullptr) xml_.fail(element, fmt::format("found no {}, expected a link", role));
    return xml_.required(*end, "link");
  }

  XmlRobot xml_;
  std::filesystem::path file_;
  const XmlElement* root_;
  LinkTree tree_{xml_, file_};
  ArmModel arm_;
};

}  // namespace

ImportedArm readUrdf(const std::string& text, const std::filesystem::path& file) { return UrdfArm(text, file).read(); }

}  // namespace simgap
