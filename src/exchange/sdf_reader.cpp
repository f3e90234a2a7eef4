// SDF: links and joints of one model. Poses, limits, frictions, springs and mimics; all else is named with its line.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "arm_exchange.h"
#include "link_tree.h"
#include "sdf_muscles.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr int kDeepestSdf = 100;       // frames that stand in one another
constexpr double kSdfUnlimited = 1e6;  // [rad] or [m]: SDF writes 1e16 where nothing limits a joint

const std::map<std::string, std::string> kIgnoredInSdf = {
    {"visual", "looks: left out"},
    {"sensor", "a sensor: left out"},
    {"light", "looks: left out"},
    {"plugin", "for a simulator: left out"},
    {"physics", "how a simulator solves, not what: left out"},
    {"scene", "looks: left out"},
    {"gui", "looks: left out"},
    {"self_collide", "contacts are not modelled: left out"},
    {"enable_wind", "no air acts on bodies: left out"},
    {"effort", "left out: no limit of a joint's torque"},
    {"velocity", "left out: no limit of a joint's velocity"},
    {"@version", "the file's version: left out"},
    {"@canonical_link", "which link is the model's: left out"},
};

/// Whether a file of the format's version ("1.4") is older than 1.`minor`.
bool isBefore(const std::string& version, int minor) {
  const std::size_t dot = version.find('.');
  const int major = std::atoi(version.c_str());
  return major < 1 || (major == 1 && (dot == std::string::npos || std::atoi(version.c_str() + dot + 1) < minor));
}

class SdfArm {
 public:
  SdfArm(const std::string& text, const std::filesystem::path& file)
      : file_(file), root_(&xml_.parse(text, file, {"sdf"})) {}

  ImportedArm read() {
    xml_.refuseMacros(*root_);
    const char* const version = xml_.find(*root_, "version");
    axes_in_model_ = version != nullptr && isBefore(version, 5);
    frame_of_pose_ = version != nullptr && isBefore(version, 7);
    const XmlElement& model = findModel();
    arm_.name = xml_.required(model, "name");
    findFrames(model);
    for (const auto* e = model.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) readLink(*e);
    for (const auto* e = model.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) readJoint(*e);
    for (const char* nested : {"model", "include"}) {
      if (const auto* e = model.FirstChildElement(nested)) xml_.fail(*e, "found a model in the model, expected links");
    }
    tree_.placeBase(placed_);
    arm_ = tree_.build(std::move(arm_));
    readSdfMuscles(model, tree_, xml_, arm_);
    std::vector<ExchangeRemark> remarks = xml_.finish(kIgnoredInSdf);
    return {checkedArm(std::move(arm_), file_, tree_.places()), std::move(remarks)};
  }

 private:
  /// Where a frame of the file is.
  struct Frame {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    std::string relative_to;
    const XmlElement* element = nullptr;
  };

  static const char* textOf(const XmlElement& element) {
    const char* const text = element.GetText();
    return text == nullptr ? "" : text;
  }

  std::string word(const XmlElement& element) {
    const std::string text = textOf(element);
    const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
    xml_.checkText(element, text);
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
  }

  double number(const XmlElement& parent, const char* name, double fallback) {
    const XmlElement* const found = xml_.child(parent, name);
    return found == nullptr ? fallback : xml_.number(*found, name, textOf(*found));
  }

  /// Infinity, or a number that means it, is no limit.
  double limit(const XmlElement& parent, const char* name, double none) {
    const XmlElement* const found = xml_.child(parent, name);
    if (found == nullptr || std::abs(std::strtod(textOf(*found), nullptr)) >= kSdfUnlimited) return none;
    return xml_.number(*found, name, textOf(*found));
  }

  bool truth(const XmlElement& element, std::string_view said) const {
    if (said == "true" || said == "1") return true;
    if (said == "false" || said == "0") return false;
    xml_.fail(element, fmt::format("found '{}', expected true or false", abridged(said)));
  }

  /// x y z roll pitch yaw, or with a quaternion x y z w.
  Eigen::Isometry3d poseOf(const XmlElement& element) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    for (const char* said : {"frame", "relative_to"}) {
      if (const char* other = element.Attribute(said); other && !*other) xml_.find(element, said);  // its usual one
    }
    std::vector<double> v = xml_.numbers(element, "pose", textOf(element));
    const char* const format = xml_.find(element, "rotation_format");
    const char* const degrees = xml_.find(element, "degrees");
    const bool quaternion = format != nullptr && std::string_view(format) == "quat_xyzw";
    if (format != nullptr && !quaternion && std::string_view(format) != "euler_rpy") {
      xml_.fail(element, fmt::format("rotation_format: found '{}', expected euler_rpy or quat_xyzw", abridged(format)));
    }
    if (v.empty()) return frame;
    if (v.size() != (quaternion ? 7U : 6U)) {
      xml_.fail(element, fmt::format("found {} numbers, expected {}", v.size(), quaternion ? 7 : 6));
    }
    frame.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    if (quaternion) {
      const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
      if (std::abs(q.norm() - 1.0) > 1e-3) xml_.fail(element, "found a quaternion that is not of unit length");
      frame.linear() = q.normalized().toRotationMatrix();
    } else {
      const bool in_degrees = degrees != nullptr && truth(element, degrees);
      frame.linear() =
          fromRollPitchYaw((in_degrees ? kDegree : 1.0) * Eigen::Vector3d(v[3], v[4], v[5])).toRotationMatrix();
    }
    return frame;
  }

  /// The one model that has joints; others only stand about.
  const XmlElement& findModel() {
    const XmlElement* place = root_;
    if (const XmlElement* const world = xml_.child(*root_, "world")) {
      place = world;
      xml_.find(*world, "name");
      if (const XmlElement* const gravity = xml_.child(*world, "gravity")) {
        arm_.gravity = xml_.vector3(*gravity, "gravity", textOf(*gravity));
      }
    }
    const XmlElement* found = nullptr;
    for (const auto* e = place->FirstChildElement("model"); e; e = e->NextSiblingElement("model")) {
      if (e->FirstChildElement("joint") == nullptr) {
        xml_.remark(*e, "model without joints", "left out: nothing of it moves", false);
        continue;
      }
      if (found != nullptr) xml_.fail(*e, "found a second model with joints, expected one");
      found = e;
    }
    if (found == nullptr) xml_.fail(*place, "found no model with joints, expected one");
    xml_.understand(*found);
    return *found;
  }

  void findFrames(const XmlElement& model) {
    if (const XmlElement* const pose = xml_.child(model, "pose")) base_ = poseOf(*pose);
    if (const XmlElement* const still = xml_.child(model, "static"); still && truth(*still, word(*still))) {
      xml_.fail(*still, "found a model that is static, expected one whose joints move");
    }
    for (const char* tag : {"link", "joint", "frame"}) {
      for (const auto* e = model.FirstChildElement(tag); e; e = e->NextSiblingElement(tag)) {
        xml_.understand(*e);
        Frame frame;
        frame.element = e;
        if (*tag == 'j') {
          const XmlElement* const link = xml_.child(*e, "child");
          if (link == nullptr) xml_.fail(*e, "found no child, expected a link");
          frame.relative_to = word(*link);
        }
        if (*tag == 'f') {
          if (const char* attached = xml_.find(*e, "attached_to")) frame.relative_to = attached;
        }
        if (const XmlElement* const pose = xml_.child(*e, "pose")) {
          frame.pose = poseOf(*pose);
          const char* const usual = frame_of_pose_ ? xml_.find(*pose, "frame") : nullptr;
          for (const char* other : {usual, xml_.find(*pose, "relative_to")}) {
            if (other && *other) frame.relative_to = other;
          }
        }
        const std::string name = xml_.required(*e, "name");
        if (!frames_.emplace(name, frame).second) xml_.fail(*e, fmt::format("the name '{}' is taken", abridged(name)));
      }
    }
  }

  /// In the model's frame.
  Eigen::Isometry3d inModel(const std::string& name, const XmlElement& asked, int depth = 0) const {
    if (name.empty() || name == "__model__") return Eigen::Isometry3d::Identity();
    if (name == "world") return base_.inverse();
    const auto frame = frames_.find(name);
    if (frame == frames_.end()) {
      xml_.fail(asked, fmt::format("found '{}', expected the name of a link, joint or frame", abridged(name)));
    }
    if (depth > kDeepestSdf) xml_.fail(asked, fmt::format("frame '{}' stands in itself", abridged(name)));
    return inModel(frame->second.relative_to, *frame->second.element, depth + 1) * frame->second.pose;
  }

  void readLink(const XmlElement& element) {
    const std::string name = xml_.required(element, "name");
    const XmlElement* const inertial = xml_.child(element, "inertial");
    tree_.addLink(element, name, inertial == nullptr ? MassProperties{} : readInertial(*inertial));
    placed_[name] = base_ * inModel(name, element);
  }

  MassProperties readInertial(const XmlElement& element) {
    MassProperties mass;
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    if (const XmlElement* const pose = xml_.child(element, "pose")) frame = poseOf(*pose);
    mass.mass = number(element, "mass", 1.0);
    if (mass.mass < 0.0) xml_.fail(element, fmt::format("mass: found {}, expected >= 0", mass.mass));
    mass.inertia.setIdentity();
    if (const XmlElement* const i = xml_.child(element, "inertia")) {
      const double xx = number(*i, "ixx", 1.0), yy = number(*i, "iyy", 1.0), zz = number(*i, "izz", 1.0);
      const double xy = number(*i, "ixy", 0.0), xz = number(*i, "ixz", 0.0), yz = number(*i, "iyz", 0.0);
      mass.inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    }
    mass.centre_of_mass = frame.translation();
    mass.inertia = (frame.linear() * mass.inertia * frame.linear().transpose()).eval();
    return mass;
  }

  void readJoint(const XmlElement& element) {
    LinkJoint joint;
    joint.place = xml_.place(element);
    const std::string name = xml_.required(element, "name"), type = xml_.required(element, "type");
    joint.fixed = type == "fixed";
    const bool unlimited = type == "continuous";
    if (const JointKind* const kind = findKind(&JointKind::sdf, unlimited ? "revolute" : type)) {
      joint.joint.type = kind->type;
    } else if (!joint.fixed) {
      xml_.fail(element, fmt::format("type: found '{}', expected revolute, continuous, prismatic, ball or fixed",
                                     abridged(type)));
    }
    const XmlElement* const parent = xml_.child(element, "parent");
    if (parent == nullptr) xml_.fail(element, "found no parent, expected a link or world");
    joint.parent = word(*parent);
    joint.child = word(*xml_.child(element, "child"));  // findFrames saw one
    if (joint.parent == "world") addWorld(element);
    const Eigen::Isometry3d here = inModel(name, element);
    joint.in_parent = inModel(joint.parent, element).inverse() * here;
    joint.in_child = inModel(joint.child, element).inverse() * here;
    if (joint.joint.hasAxis() && !joint.fixed) readAxis(element, type, here, joint);
    tree_.addJoint(joint, name);
  }

  void addWorld(const XmlElement& element) {
    if (on_world_) return;
    on_world_ = true;
    placed_["world"] = Eigen::Isometry3d::Identity();
    tree_.addLink(element, "world", {});
  }

  void readAxis(const XmlElement& element, const std::string& type, const Eigen::Isometry3d& here, LinkJoint& joint) {
    Joint& j = joint.joint;
    j.axis = Eigen::Vector3d::UnitZ();
    const XmlElement* const axis = xml_.child(element, "axis");
    if (axis == nullptr) return;
    if (const XmlElement* const xyz = xml_.child(*axis, "xyz")) {
      j.axis = xml_.vector3(*xyz, "xyz", textOf(*xyz));
      const char* const frame = xml_.find(*xyz, "expressed_in");
      const XmlElement* const old = xml_.child(*axis, "use_parent_model_frame");
      const bool in_model = old == nullptr ? axes_in_model_ : truth(*old, word(*old));
      const std::string seen_from = frame != nullptr && *frame ? frame : in_model ? "__model__" : "";
      if (!seen_from.empty()) j.axis = here.linear().transpose() * (inModel(seen_from, *xyz).linear() * j.axis);
      if (j.axis.norm() < 1e-9) xml_.fail(*xyz, "found a zero vector, expected an axis");
      j.axis = tidyAxis(j.axis);
    }
    if (const XmlElement* const range = xml_.child(*axis, "limit"); range && type != "continuous") {
      j.lower_limit = limit(*range, "lower", j.lower_limit);
      j.upper_limit = limit(*range, "upper", j.upper_limit);
      if (j.lower_limit > j.upper_limit) {
        xml_.fail(*range, fmt::format("found lower {} above upper {}", j.lower_limit, j.upper_limit));
      }
    }
    if (const XmlElement* const dynamics = xml_.child(*axis, "dynamics")) {
      j.viscous_friction = number(*dynamics, "damping", 0.0);
      j.coulomb_friction = number(*dynamics, "friction", 0.0);
      j.spring_stiffness = number(*dynamics, "spring_stiffness", 0.0);
      j.spring_rest = number(*dynamics, "spring_reference", 0.0);
      if (std::min({j.viscous_friction, j.coulomb_friction, j.spring_stiffness}) < 0.0) {
        xml_.fail(*dynamics, "found a number < 0");
      }
    }
    if (const XmlElement* const mimic = xml_.child(*axis, "mimic")) {
      joint.leader = xml_.required(*mimic, "joint");
      joint.multiplier = number(*mimic, "multiplier", 1.0);
      joint.offset = number(*mimic, "offset", 0.0) - joint.multiplier * number(*mimic, "reference", 0.0);
    }
  }

  XmlRobot xml_;
  std::filesystem::path file_;
  const XmlElement* root_;
  LinkTree tree_{xml_, file_, "Gazebo takes 1 kg and 1 kg m^2"};
  ArmModel arm_;
  Eigen::Isometry3d base_ = Eigen::Isometry3d::Identity();  ///< of the model in the world
  std::map<std::string, Frame> frames_;
  std::map<std::string, Eigen::Isometry3d> placed_;  ///< links, in the world
  bool axes_in_model_ = false;                       ///< where they say nothing: before version 1.5
  bool frame_of_pose_ = false;                       ///< `frame` is `relative_to`: before version 1.7
  bool on_world_ = false;
};

}  // namespace

ImportedArm readSdf(const std::string& text, const std::filesystem::path& file) { return SdfArm(text, file).read(); }

}  // namespace simgap
