// An arm as an MJCF model. Its motorised muscles become actuators with an affine law,
//
//   force = k (L_K0 + L_SR) - k r u - k L - D dL/dt,   never above 0
//
// in which u is the shaft's angle [rad]: what pulls in MuJoCo has a negative force (000 eq. 3-4, 12).
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "arm_exchange.h"
#include "mjcf_joints.h"
#include "remark_list.h"
#include "simgap/core/decompositions.h"
#include "simgap/exchange/exchange.h"
#include "simgap/model/arm/kinematics.h"
#include "xml_text.h"

namespace simgap {
namespace {

constexpr double kSamePlace = 1e-12;
constexpr double kStrongest = 1e6;     ///< [N] where a force needs an end
constexpr double kTinyMass = 1e-6;     ///< [kg] of a body that MuJoCo wants one of
constexpr double kTinyInertia = 1e-9;  ///< [kg m^2]
/// MuJoCo refuses principal moments below 1e-14 kg m^2, whatever its boundinertia says.
constexpr double kLeastInertia = 2e-14;  ///< [kg m^2]

class MjcfWriter {
 public:
  explicit MjcfWriter(const ArmModel& model) : model_(model), sites_(model.bodies.size()) {}

  ExportedArm write() {
    nameSoftJoints(model_, remarks_);
    for (const Muscle& muscle : model_.muscles) writeMuscle(muscle);
    for (const PassiveTendon& tendon : model_.tendons) writePassive(tendon);
    nameWhatIsLost();
    std::string text = fmt::format("<mujoco model=\"{}\">\n", xmlText(model_.name));
    text += "  <compiler angle=\"radian\" autolimits=\"true\"/>\n";
    text += fmt::format("  <option gravity=\"{}\" timestep=\"{}\" integrator=\"implicitfast\"/>\n",
                        xmlNumbers(model_.gravity), kMjcfTimeStep);
    text += "  <worldbody>\n";
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].fixed) text += content(static_cast<int>(b), Eigen::Isometry3d::Identity(), "    ");
    }
    text += children(worldBodies(), Eigen::Isometry3d::Identity(), "    ");
    text += "  </worldbody>\n";
    if (!tendons_.empty()) text += "  <tendon>\n" + tendons_ + "  </tendon>\n";
    if (const std::string tied = mjcfCouplings(model_); !tied.empty())
      text += "  <equality>\n" + tied + "  </equality>\n";
    if (!actuators_.empty()) text += "  <actuator>\n" + actuators_ + "  </actuator>\n";
    return {text + "</mujoco>\n", remarks_.take()};
  }

 private:
  struct Site {
    std::string name;
    Eigen::Vector3d point;
  };
  /// A body of MuJoCo: the last of a chain of massless ones, with all their joints.
  struct Link {
    int body;
    std::vector<int> joints;
  };

  std::vector<int> worldBodies() const {
    std::vector<int> fixed;
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].fixed) fixed.push_back(static_cast<int>(b));
    }
    return fixed;
  }

  std::vector<int> jointsOf(int body) const {
    std::vector<int> joints;
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      if (model_.joints[j].parent == body) joints.push_back(static_cast<int>(j));
    }
    return joints;
  }

  bool bare(int body) const {
    const Body& b = model_.bodies[body];
    return massProperties(b).mass <= 0.0 && b.surfaces.empty() && b.parts.empty() && sites_[body].empty();
  }

  /// Massless bodies from this one on whose joints the next one with mass has, too; none where reading the file would
  /// give them other names, or put them elsewhere: joints of one body are read as bodies that stand where it does.
  std::vector<int> passedOver(int body) const {
    std::vector<int> chain;
    for (; bare(body) && jointsOf(body).size() == 1; body = model_.joints[jointsOf(body)[0]].child) {
      chain.push_back(body);
    }
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const Eigen::Isometry3d next = drawnPose(model_.joints[jointsOf(chain[i])[0]]);
      if (model_.bodies[chain[i]].name != fmt::format("{}_{}", model_.bodies[body].name, i + 1)) return {};
      if (!next.isApprox(Eigen::Isometry3d::Identity(), kSamePlace)) return {};
    }
    return chain;
  }

  /// The bodies that hang on those of `parents`, whose frame is `offset` in the one that is written.
  std::string children(const std::vector<int>& parents, const Eigen::Isometry3d& offset, const std::string& indent) {
    std::string text;
    for (const int parent : parents) {
      for (const int first : jointsOf(parent)) {
        Link link{model_.joints[first].child, {first}};
        Eigen::Isometry3d frame = offset * drawnPose(model_.joints[first]);
        for (const int over : passedOver(link.body)) {
          link.joints.push_back(jointsOf(over)[0]);
          const Joint& next = model_.joints[link.joints.back()];
          frame = frame * drawnPose(next);
          link.body = next.child;
        }
        text += body(link, frame, indent);
      }
    }
    return text;
  }

  std::string body(const Link& link, const Eigen::Isometry3d& frame, const std::string& indent) {
    const std::string inner = indent + "  ";
    std::string text =
        fmt::format("{}<body name=\"{}\"{}>\n", indent, xmlText(model_.bodies[link.body].name), mjcfFrame(frame));
    // Joints of the bodies that were passed over, in this body's frame.
    std::vector<Eigen::Isometry3d> in_link(link.joints.size(), Eigen::Isometry3d::Identity());
    for (std::size_t i = link.joints.size(); i-- > 1;) {
      in_link[i - 1] = in_link[i] * drawnPose(model_.joints[link.joints[i]]).inverse();
    }
    for (std::size_t i = 0; i < link.joints.size(); ++i) {
      const Joint& moving = model_.joints[link.joints[i]];
      text += mjcfJoint(model_, moving, in_link[i], inner);
      if (moving.stop.stiffness <= 0.0) continue;
      remarks_.add(fmt::format("limits of joint '{}'", moving.name),
                   "left out: MuJoCo's balls have no swing and twist");
    }
    text += inertial(link.body, inner);
    text += content(link.body, Eigen::Isometry3d::Identity(), inner);
    text += children({link.body}, Eigen::Isometry3d::Identity(), inner);
    return text + indent + "</body>\n";
  }

  std::string inertial(int index, const std::string& indent) {
    const Body& body = model_.bodies[index];
    MassProperties mass = massProperties(body);
    if (mass.mass <= 0.0) {
      remarks_.add(fmt::format("body '{}' without mass", body.name),
                   fmt::format("{} kg: MuJoCo wants some of every body that moves", kTinyMass));
      mass = {kTinyMass, Eigen::Vector3d::Zero(), kTinyInertia * Eigen::Matrix3d::Identity()};
    }
    if (const SymmetricEigen principal = symmetricEigen(mass.inertia); principal.values[0] < kLeastInertia) {
      remarks_.add(fmt::format("body '{}' with hardly any inertia", body.name),
                   fmt::format("{} kg m^2 about each axis at least: MuJoCo takes no less", kLeastInertia));
      mass.inertia =
          principal.vectors * principal.values.cwiseMax(kLeastInertia).asDiagonal() * principal.vectors.transpose();
    }
    const Eigen::Matrix3d& i = mass.inertia;
    return fmt::format("{}<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{} {} {} {} {} {}\"/>\n", indent,
                       xmlNumbers(mass.centre_of_mass), mass.mass, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                       i(1, 2));
  }

  /// Shapes to look at, surfaces to wrap over, points of lines. None of them collides or weighs anything.
  std::string content(int index, const Eigen::Isometry3d& frame, const std::string& indent) const {
    const Body& body = model_.bodies[index];
    std::string text;
    for (const Part& part : body.parts) text += mjcfGeom(part, indent);
    for (const Surface& surface : body.surfaces) {
      text += fmt::format(
          "{}<geom name=\"{}\" type=\"{}\" pos=\"{}\"{} contype=\"0\" conaffinity=\"0\" mass=\"0\" "
          "rgba=\".5 .5 .9 .4\"",
          indent, xmlText(surfaceName(body, surface)), surface.shape == Surface::Shape::kSphere ? "sphere" : "cylinder",
          xmlNumbers(frame * surface.position), surface.shape == Surface::Shape::kSphere ? "" : alongZ(surface.axis));
      text += surface.shape == Surface::Shape::kSphere
                  ? fmt::format(" size=\"{}\"/>\n", surface.radius)
                  : fmt::format(" size=\"{} {}\"/>\n", surface.radius, surface.radius);
    }
    for (const Site& site : sites_[index]) {
      text += fmt::format("{}<site name=\"{}\" pos=\"{}\"/>\n", indent, xmlText(site.name), xmlNumbers(site.point));
    }
    return text;
  }

  /// Its own, with its body's before it where another body has a surface of that name: geoms share their names.
  std::string surfaceName(const Body& body, const Surface& surface) const {
    const auto has = [&](const Body& b) {
      return std::ranges::find(b.surfaces, surface.name, &Surface::name) != b.surfaces.end();
    };
    return std::ranges::count_if(model_.bodies, has) > 1 ? body.name + "/" + surface.name : surface.name;
  }

  std::string site(const Attachment& at, const std::string& name) {
    sites_[at.body].push_back({name, at.point});
    return xmlText(name);
  }

  /// The path as <spatial> or <fixed>. \returns whether MuJoCo has such a path
  bool writePath(const TendonPath& path, const std::string& name, const std::string& attributes) {
    if (path.jointsOnly()) {
      tendons_ += fmt::format("    <fixed name=\"{}\"{}>\n", xmlText(name), attributes);
      for (const Station& station : path.between) {
        tendons_ += fmt::format("      <joint joint=\"{}\" coef=\"{}\"/>\n", xmlText(model_.joints[station.joint].name),
                                station.radius);
      }
      tendons_ += "    </fixed>\n";
      return true;
    }
    if (std::ranges::find(path.between, Station::Kind::kJoint, &Station::kind) != path.between.end()) {
      remarks_.add(fmt::format("'{}'", name), "left out: MuJoCo has no line over points and wheels at once");
      return false;
    }
    std::string text;
    int count = 0;
    const auto point = [&](const Attachment& at) {
      text += fmt::format("      <site site=\"{}\"/>\n", site(at, fmt::format("{}/{}", name, ++count)));
    };
    point(path.attachments[0]);
    for (const Station& station : path.between) {
      if (station.kind == Station::Kind::kPoint) {
        point(station.at);
      } else if (station.kind == Station::Kind::kPulley) {
        text += fmt::format("      <pulley divisor=\"{}\"/>\n", station.divisor);
      } else {
        const Body& body = model_.bodies[station.at.body];
        text += fmt::format("      <geom geom=\"{}\"", xmlText(surfaceName(body, body.surfaces[station.surface])));
        if (station.sided) {
          Attachment side = station.at;
          if (station.side_body >= 0) side.body = station.side_body;
          text += fmt::format(" sidesite=\"{}\"", site(side, fmt::format("{}/side {}", name, ++count)));
        }
        text += "/>\n";
      }
    }
    point(path.attachments[1]);
    tendons_ += fmt::format("    <spatial name=\"{}\"{}>\n{}    </spatial>\n", xmlText(name), attributes, text);
    return true;
  }

  void writeActuator(const std::string& name, double gain, const std::array<double, 3>& bias, bool only_pulls) {
    actuators_ += fmt::format(
        "    <general name=\"{}\" tendon=\"{}\" gainprm=\"{}\" biastype=\"affine\" "
        "biasprm=\"{} {} {}\"",
        xmlText(name), xmlText(name), gain, bias[0], bias[1], bias[2]);
    if (only_pulls) actuators_ += fmt::format(" forcerange=\"{} 0\"", -kStrongest);
    actuators_ += "/>\n";
  }

  void writeMuscle(const Muscle& muscle) {
    if (!writePath(muscle, muscle.name, "")) return;
    const ShockCord& cord = muscle.shock_cord;
    writeActuator(muscle.name, -cord.stiffness * muscle.spindle_radius,
                  {cord.stiffness * (muscle.kite_line_length + cord.rest_length), -cord.stiffness, -cord.damping},
                  true);
  }

  void writePassive(const PassiveTendon& tendon) {
    const std::string_view kind = tendon.kind->name;
    const auto& p = tendon.p;
    const bool elastic = kind == "ligament" || kind == "spring";
    if (tendon.kind->at_joint) {
      writeJointDrive(tendon);
    } else if (kind == "line-servo") {
      if (writePath(tendon, tendon.name, "")) {
        writeActuator(tendon.name, p[0], {p[0] * p[1], -p[0], -p[2]}, false);
      }
    } else if (!elastic && kind != "constant-force") {
      remarks_.add(fmt::format("'{}' ({})", tendon.name, kind), "left out: MJCF has no such line");
    } else if (elastic && p[0] >= 0.0) {
      const std::string rest = kind == "spring" ? fmt::format("{}", p[0]) : fmt::format("0 {}", p[0]);
      writePath(tendon, tendon.name,
                fmt::format(" stiffness=\"{}\" springlength=\"{}\" damping=\"{}\"", p[1], rest, p[2]));
      if (kind == "ligament" && p[2] > 0.0) {
        remarks_.add("a ligament's damping", "acts in MuJoCo while it is slack, too (motions only)");
      }
    } else if (writePath(tendon, tendon.name, "")) {
      if (elastic) writeActuator(tendon.name, 0.0, {p[1] * p[0], -p[1], -p[2]}, false);
      if (!elastic && p[0] != 0.0) writeActuator(tendon.name, 0.0, {-p[0], 0.0, 0.0}, false);
    }
  }

  void writeJointDrive(const PassiveTendon& drive) {
    const auto& p = drive.p;
    const std::string joint = xmlText(model_.joints[drive.between[0].joint].name);
    if (drive.kind->name == "joint-motor") {
      actuators_ += fmt::format("    <motor name=\"{}\" joint=\"{}\" gear=\"{}\"/>\n", xmlText(drive.name), joint,
                                p[0] * p[1] * p[2]);
      remarks_.add("a motor at a joint",
                   "its control is the current in A; its friction is a part of the joint's damping", false);
    } else if (drive.kind->name == "joint-servo" && p[1] != 0.0) {
      actuators_ += fmt::format(
          "    <general name=\"{}\" joint=\"{}\" gainprm=\"{}\" biastype=\"affine\" biasprm=\"{} {} {}\"/>\n",
          xmlText(drive.name), joint, p[0], p[0] * p[1], -p[0], -p[2]);
    } else if (drive.kind->name == "joint-servo") {
      actuators_ += fmt::format("    <position name=\"{}\" joint=\"{}\" kp=\"{}\" kv=\"{}\"/>\n", xmlText(drive.name),
                                joint, p[0], p[2]);
    } else {
      remarks_.add(fmt::format("'{}' ({})", drive.name, drive.kind->name), "left out: MJCF has no such drive");
    }
  }

  void nameWhatIsLost() {
    if (std::ranges::any_of(model_.muscles, &Muscle::rope)) {
      remarks_.add("line: rope", "a straight line: MuJoCo's tendons bend over surfaces that are named, not over bones");
    }
    for (const Extension& extension : model_.extensions) {
      remarks_.add(fmt::format("extension '{}'", extension.effect), "left out: MJCF has no such effect");
    }
    if (model_.muscles.empty()) return;
    remarks_.add("motors and gearboxes", "left out: the control of an actuator is the angle of its shaft [rad]", false);
    remarks_.add("where a line ends and its cord begins", "left out: both lengths are one", false);
  }

  const ArmModel& model_;
  std::vector<std::vector<Site>> sites_;  ///< by body
  std::string tendons_, actuators_;
  RemarkList remarks_;
};

}  // namespace

ExportedArm writeMjcf(const ArmModel& model) { return MjcfWriter(model).write(); }

}  // namespace simgap
