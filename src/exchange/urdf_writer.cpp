// The bodies and joints of an arm as a URDF robot. URDF puts a link's frame into the joint that moves it.
#include <fmt/format.h>

#include "arm_exchange.h"
#include "remark_list.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"
#include "simgap/core/units.h"
#include "simgap/exchange/exchange.h"
#include "xml_text.h"

namespace simgap {
namespace {

constexpr double kNoLimit = 1e3;  ///< [N m], [rad/s] that URDF wants of joints with a range

class UrdfWriter {
 public:
  explicit UrdfWriter(const ArmModel& model)
      : model_(model), frames_(model.bodies.size(), Eigen::Isometry3d::Identity()) {}

  ExportedArm write() {
    for (const Joint& joint : model_.joints) {
      frames_[joint.child].linear() = joint.child_orientation.toRotationMatrix();
      frames_[joint.child].translation() = joint.child_position;
    }
    std::string text = fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", xmlText(model_.name));
    text += baseLinks();
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (!model_.bodies[b].fixed) text += link(static_cast<int>(b));
    }
    for (const Joint& joint : model_.joints) text += joint.hasAxis() ? oneAxis(joint) : ball(joint);
    nameWhatIsLost();
    return {text + "</robot>\n", remarks_.take()};
  }

 private:
  static std::string origin(const Eigen::Isometry3d& frame) {
    const Eigen::Matrix3d& r = frame.linear();
    // R = Rz(yaw) Ry(pitch) Rx(roll)
    const double pitch = std::atan2(-r(2, 0), std::hypot(r(0, 0), r(1, 0)));
    const bool locked = std::hypot(r(0, 0), r(1, 0)) < 1e-9;
    const double roll = locked ? std::atan2(-r(1, 2), r(1, 1)) : std::atan2(r(2, 1), r(2, 2));
    const double yaw = locked ? 0.0 : std::atan2(r(1, 0), r(0, 0));
    return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", xmlNumbers(frame.translation()),
                       xmlNumbers({roll, pitch, yaw}));
  }

  std::string baseLinks() {
    std::vector<std::string> names;
    for (const Body& body : model_.bodies) {
      if (body.fixed) names.push_back(body.name);
    }
    std::string text = fmt::format("  <link name=\"{}\"/>\n", xmlText(names[0]));
    for (std::size_t i = 1; i < names.size(); ++i) {
      text += fmt::format(
          "  <link name=\"{0}\"/>\n  <joint name=\"{0}_base\" type=\"fixed\"><parent link=\"{1}\"/>"
          "<child link=\"{0}\"/></joint>\n",
          xmlText(names[i]), xmlText(names[0]));
    }
    return text;
  }

  static std::string inertial(const MassProperties& mass) {
    const Eigen::Matrix3d& i = mass.inertia;
    Eigen::Isometry3d centre = Eigen::Isometry3d::Identity();
    centre.translation() = mass.centre_of_mass;
    return fmt::format(
        "    <inertial>{}<mass value=\"{}\"/><inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" "
        "iyz=\"{}\" izz=\"{}\"/></inertial>\n",
        origin(centre), mass.mass, i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2));
  }

  std::string link(int index) const {
    const Eigen::Isometry3d to_link = frames_[index].inverse();
    MassProperties mass = massProperties(model_.bodies[index]);
    mass.centre_of_mass = to_link * mass.centre_of_mass;
    mass.inertia = (to_link.linear() * mass.inertia * to_link.linear().transpose()).eval();
    std::string text = fmt::format("  <link name=\"{}\">\n", xmlText(model_.bodies[index].name));
    if (mass.mass > 0.0) text += inertial(mass);
    for (const Part& part : model_.bodies[index].parts) text += visual(part, to_link);
    return text + "  </link>\n";
  }

  static std::string visual(const Part& part, const Eigen::Isometry3d& to_link) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.translation() = part.position;
    std::string shape;
    if (part.shape == Part::Shape::kSphere) {
      shape = fmt::format("<sphere radius=\"{}\"/>", part.radius);
    } else if (part.shape == Part::Shape::kBox) {
      frame.linear() = part.orientation.toRotationMatrix();
      shape = fmt::format("<box size=\"{}\"/>", xmlNumbers(part.size));
    } else if (part.shape == Part::Shape::kCylinder || part.shape == Part::Shape::kCapsule) {
      frame.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), part.axis).toRotationMatrix();
      shape = fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", part.radius, part.length);
    } else {
      return "";
    }
    return fmt::format("    <visual>{}<geometry>{}</geometry></visual>\n", origin(to_link * frame), shape);
  }

  Eigen::Isometry3d inParent(const Joint& joint) const {
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    at.linear() = joint.parent_orientation.toRotationMatrix();
    at.translation() = joint.parent_position;
    return frames_[joint.parent].inverse() * at;
  }

  static std::string jointText(const std::string& name, const char* type, const std::string& parent,
                               const std::string& child, const std::string& origin, const Eigen::Vector3d& axis,
                               const std::string& more) {
    return fmt::format(
        "  <joint name=\"{}\" type=\"{}\">\n    {}\n    <parent link=\"{}\"/><child link=\"{}\"/><axis xyz=\"{}\"/>\n{}"
        "  </joint>\n",
        xmlText(name), type, origin, xmlText(parent), xmlText(child), xmlNumbers(axis), more);
  }

  static std::string dynamics(const Joint& joint) {
    if (joint.viscous_friction == 0.0 && joint.coulomb_friction == 0.0) return "";
    return fmt::format("    <dynamics damping=\"{}\" friction=\"{}\"/>\n", joint.viscous_friction,
                       joint.coulomb_friction);
  }

  std::string oneAxis(const Joint& joint) {
    const bool limited = joint.lower_limit > -Joint::kUnlimited || joint.upper_limit < Joint::kUnlimited;
    std::string more = dynamics(joint);
    if (limited || joint.slides()) {
      more += fmt::format("    <limit lower=\"{}\" upper=\"{}\" effort=\"{}\" velocity=\"{}\"/>\n",
                          std::max(joint.lower_limit, -kNoLimit), std::min(joint.upper_limit, kNoLimit), kNoLimit,
                          kNoLimit);
      remarks_.add("effort and velocity of <limit>", fmt::format("{}: no limit is known", kNoLimit), false);
    }
    if (joint.follows()) {
      more += fmt::format("    <mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                          xmlText(model_.joints[joint.leader].name), joint.coupling_ratio, joint.coupling_offset);
    }
    if (joint.spring_stiffness > 0.0) {
      remarks_.add(fmt::format("spring of joint '{}'", joint.name), "left out: URDF has no joint springs");
    }
    return jointText(joint.name, limited || joint.slides() ? kindOf(joint.type).urdf : "continuous",
                     model_.bodies[joint.parent].name, model_.bodies[joint.child].name, origin(inParent(joint)),
                     joint.axis, more);
  }

  /// Three hinges, R = Rx Ry Rz, over two links without mass.
  std::string ball(const Joint& joint) {
    remarks_.add(fmt::format("ball '{}'", joint.name),
                 "three hinges about x, y and z, in this order: URDF has no ball; two of its links have no mass");
    if (joint.stop.stiffness > 0.0) {
      remarks_.add(fmt::format("limits of joint '{}'", joint.name), "left out: its three hinges turn freely");
    }
    if (joint.spring_stiffness > 0.0) {
      remarks_.add(fmt::format("spring of joint '{}'", joint.name), "left out: URDF has no joint springs");
    }
    const std::array<const char*, 3> letters = {"_x", "_y", "_z"};
    std::string parent = model_.bodies[joint.parent].name, text;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const std::string name = joint.name + letters[i];
      const std::string child = i == 2 ? model_.bodies[joint.child].name : name + "_link";
      if (i < 2) text += fmt::format("  <link name=\"{}\"/>\n", xmlText(child));
      text += jointText(name, "continuous", parent, child, i == 0 ? origin(inParent(joint)) : "",
                        Eigen::Vector3d::Unit(i), dynamics(joint));
      parent = child;
    }
    return text;
  }

  void nameWhatIsLost() {
    const auto lost = [&](std::size_t count, const std::string& what) {
      if (count > 0) remarks_.add(fmt::format("{} {}", count, what), "left out: URDF holds bodies and joints only");
    };
    lost(model_.muscles.size(), "muscles");
    lost(model_.tendons.size(), "passive tendons");
    lost(model_.extensions.size(), "extensions");
    if (model_.gravity != Eigen::Vector3d(0.0, 0.0, -kEarthGravity)) remarks_.add("gravity", "left out: URDF has none");
  }

  const ArmModel& model_;
  std::vector<Eigen::Isometry3d> frames_;  ///< of links in our bodies
  RemarkList remarks_;
};

}  // namespace

ExportedArm writeUrdf(const ArmModel& model) { return UrdfWriter(model).write(); }

}  // namespace simgap
