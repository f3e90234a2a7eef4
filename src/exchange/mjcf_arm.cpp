// What an MJCF file says becomes an arm.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "arm_exchange.h"
#include "mjcf_robot.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"

namespace simgap {
namespace {

/// Where a body of the file is in the arm: joints make bodies, what is welded belongs to its parent.
struct Home {
  int body = 0;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  ///< of the file's body in that of the arm
};

class MjcfArm {
 public:
  MjcfArm(MjcfFile& file, const MjcfRobot& robot) : xml_(file.xml()), robot_(robot) {}

  const ArmPlaces& places() const { return places_; }

  /// \param file  for messages
  ArmModel build(const std::filesystem::path& file) {
    arm_.name = robot_.name;
    arm_.gravity = robot_.gravity;
    arm_.bodies.push_back({.name = "world", .fixed = true, .parts = {}, .surfaces = {}});
    for (const MjcfBody& body : robot_.bodies) names_.insert(body.name);
    for (const MjcfBody& body : robot_.bodies) addBody(body);
    if (arm_.joints.empty()) {
      throw DataError(fmt::format("{}: found no joint in the robot, expected at least one", file.filename().string()));
    }
    for (const MjcfCoupling& coupling : robot_.couplings) couple(coupling);
    for (const MjcfTendon& tendon : robot_.tendons) addTendon(tendon);
    for (const MjcfActuator& actuator : robot_.actuators) addActuator(actuator);
    return std::move(arm_);
  }

 private:
  Home homeOf(int body) const { return body < 0 ? Home{} : homes_[body]; }

  void addBody(const MjcfBody& body) {
    const Home parent = homeOf(body.parent);
    Home home{parent.body, parent.frame * body.frame};
    if (body.joints.empty()) {
      const std::string& carrier = arm_.bodies[parent.body].name;
      xml_.add(fmt::format("body '{}'", abridged(body.name)), fmt::format("welded: a part of '{}'", abridged(carrier)),
               false, body.place);
    }
    for (std::size_t i = 0; i < body.joints.size(); ++i) {
      const bool last = i + 1 == body.joints.size();
      Body link;
      link.name = last ? body.name : freeName(fmt::format("{}_{}", body.name, i + 1), names_);
      home = {static_cast<int>(arm_.bodies.size()), Eigen::Isometry3d::Identity()};
      arm_.bodies.push_back(link);
      places_["bodies " + link.name] = body.place;
      addJoint(body, body.joints[i], i == 0 ? parent : Home{home.body - 1, Eigen::Isometry3d::Identity()},
               i == 0 ? body.frame : Eigen::Isometry3d::Identity(), home.body);
    }
    if (body.joints.size() > 1) {
      xml_.add(fmt::format("body '{}' of {} joints", abridged(body.name), body.joints.size()),
               "a body per joint, the last of which has the mass", false, body.place);
    }
    homes_.push_back(home);
    Body& carrier = arm_.bodies[home.body];
    if (!carrier.fixed && body.mass.mass > 0.0) {
      carrier.parts.push_back(statedPart(freePartName(carrier, body.name), inFrame(body.mass, home.frame)));
      places_["bodies " + carrier.parts.back().name] = body.place;
    }
  }

  void addJoint(const MjcfBody& body, const MjcfJoint& from, const Home& parent, const Eigen::Isometry3d& frame,
                int child) {
    Joint joint;
    joint.name = from.name;
    joint.type = from.kind->type;
    const Eigen::Isometry3d in_parent = parent.frame * frame;
    joint.parent = parent.body;
    joint.child = child;
    joint.parent_position = in_parent * from.position;
    joint.parent_orientation = tidyRotation(in_parent.linear());
    joint.child_position = from.position;
    if (joint.hasAxis()) joint.axis = from.axis;
    joint.viscous_friction = from.damping;
    joint.coulomb_friction = from.friction_loss;
    joint.spring_stiffness = from.stiffness;
    joint.spring_rest = from.spring_reference;
    if (from.range && joint.hasAxis()) {
      joint.lower_limit = (*from.range)[0];
      joint.upper_limit = (*from.range)[1];
    } else if (from.range) {
      xml_.add("joint range of a ball",
               "left out: it limits the whole turn in MuJoCo, balls here have elastic stops of swing and of twist",
               true, body.place);
    }
    if (!from.said.empty()) joint_of_[from.said] = {static_cast<int>(arm_.joints.size()), from.reference};
    places_["joints " + joint.name] = from.place;
    arm_.joints.push_back(joint);
  }

  struct Known {
    int index;
    double reference;  ///< MuJoCo's position in the drawn pose
  };

  Known known(const std::string& name, const std::string& place) const {
    const auto found = joint_of_.find(name);
    if (found == joint_of_.end()) {
      throw DataError(fmt::format("{}: found '{}', expected the name of a hinge or slide", place, abridged(name)));
    }
    return found->second;
  }

  int jointOf(const std::string& name, const std::string& place) const {
    const int index = known(name, place).index;
    if (arm_.joints[index].hasAxis()) return index;
    throw DataError(fmt::format("{}: found the ball '{}', expected a hinge or slide", place, abridged(name)));
  }

  void couple(const MjcfCoupling& coupling) {
    const int one = jointOf(coupling.joint, coupling.place);
    Joint& joint = arm_.joints[one];
    if (coupling.of.empty()) {  // held in one place
      joint.lower_limit = joint.upper_limit = coupling.offset;
      return;
    }
    tieJoints(arm_, one, jointOf(coupling.of, coupling.place), coupling.ratio, coupling.offset, coupling.place);
  }

  Attachment siteOf(const std::string& name) const {
    const MjcfSite& site = robot_.sites.at(name);
    const Home home = homeOf(site.body);
    return {home.body, home.frame * site.point};
  }

  /// Branches of a path, each with its divisor, one that counts in full first: the first of ours always does.
  std::vector<std::pair<double, std::vector<MjcfPathElement>>> branchesOf(const MjcfTendon& tendon) const {
    std::vector<std::pair<double, std::vector<MjcfPathElement>>> branches;
    for (const MjcfPathElement& element : tendon.path) {
      if (element.kind == MjcfPathElement::Kind::kPulley || branches.empty()) branches.push_back({element.divisor, {}});
      if (element.kind != MjcfPathElement::Kind::kPulley) branches.back().second.push_back(element);
    }
    const auto full = std::ranges::find(branches, 1.0, [](const auto& branch) { return branch.first; });
    if (full == branches.end()) {
      throw DataError(
          fmt::format("{}: found a tendon all of whose branches have a divisor, expected one without", tendon.place));
    }
    std::rotate(branches.begin(), full, full + 1);
    return branches;
  }

  Station surfaceStation(const MjcfPathElement& element) {
    const MjcfSurface& from = robot_.surfaces.at(element.name);
    const Home home = homeOf(from.body);
    const Eigen::Isometry3d frame = home.frame * from.frame;
    Surface surface;
    surface.name = from.name;
    surface.shape = from.cylinder ? Surface::Shape::kCylinder : Surface::Shape::kSphere;
    surface.radius = from.radius;
    surface.position = frame.translation();
    if (from.cylinder) surface.axis = tidyAxis(frame.linear().col(2));
    Station station;
    station.kind = Station::Kind::kSurface;
    station.at.body = home.body;
    station.sided = !element.side.empty();
    if (station.sided) {
      const Attachment side = siteOf(element.side);
      station.at.point = side.point;
      if (side.body != station.at.body) station.side_body = side.body;
    }
    std::vector<Surface>& surfaces = arm_.bodies[station.at.body].surfaces;
    const auto known = std::ranges::find(surfaces, surface.name, &Surface::name);
    station.surface = static_cast<int>(known - surfaces.begin());
    if (known == surfaces.end()) surfaces.push_back(surface);
    return station;
  }

  TendonPath pathOf(const MjcfTendon& tendon) {
    TendonPath path;
    if (!tendon.joints.empty()) {
      for (const auto& [name, coefficient] : tendon.joints) {
        Station wheel;
        wheel.kind = Station::Kind::kJoint;
        wheel.joint = jointOf(name, tendon.place);
        wheel.radius = coefficient;
        path.between.push_back(wheel);
      }
      return path;
    }
    for (const auto& [divisor, elements] : branchesOf(tendon)) {
      if (!path.between.empty()) {
        Station pulley;
        pulley.kind = Station::Kind::kPulley;
        pulley.divisor = divisor;
        path.between.push_back(pulley);
      }
      for (const MjcfPathElement& element : elements) {
        Station point;
        if (element.kind == MjcfPathElement::Kind::kSite) point.at = siteOf(element.name);
        path.between.push_back(element.kind == MjcfPathElement::Kind::kSite ? point : surfaceStation(element));
      }
    }
    path.attachments = {path.between.front().at, path.between.back().at};
    path.between.pop_back();
    path.between.erase(path.between.begin());
    return path;
  }

  /// MuJoCo's length of a fixed tendon less ours, whose joints count from the drawn pose [m].
  double offsetOf(const MjcfTendon& tendon) const {
    double offset = 0.0;
    for (const auto& [name, coefficient] : tendon.joints) {
      offset += coefficient * joint_of_.at(name).reference;
    }
    return offset;
  }

  template <typename Position>
  double lengthAt(const TendonPath& path, const Position& position) const {
    std::vector<JointPosition> joints;
    for (const Joint& joint : arm_.joints) joints.push_back({Eigen::Quaterniond::Identity(), position(joint)});
    return tendonLength(arm_, path, bodiesInWorld(arm_, joints), joints);
  }

  static bool actsOn(const MjcfActuator& actuator, const MjcfTendon& tendon) {
    return !actuator.tendon.empty() && actuator.tendon == tendon.name;
  }

  /// What no joint lengthens moves none.
  void leaveOutConstant(const MjcfTendon& tendon) {
    xml_.add("tendon of one length", "left out: no joint changes it", false, tendon.place);
    for (const MjcfActuator& actuator : robot_.actuators) {
      if (!actsOn(actuator, tendon)) continue;
      xml_.add(wordsOf(actuator), "left out: no joint changes its tendon", false, actuator.place);
    }
  }

  void addTendon(const MjcfTendon& tendon) {
    const TendonPath path = pathOf(tendon);
    if (!jointsChange(path)) return leaveOutConstant(tendon);
    const double length = lengthAt(path, [](const Joint&) { return 0.0; });
    const double offset = offsetOf(tendon);
    int pulling = 0;
    for (const MjcfActuator& actuator : robot_.actuators) {
      if (!actsOn(actuator, tendon)) continue;
      if (exertsNothing(actuator)) {
        xml_.add(wordsOf(actuator), "left out: it exerts no force", false, actuator.place);
      } else if (++pulling > 1) {
        xml_.add(fmt::format("{} '{}'", actuator.tag, abridged(actuator.name)),
                 "left out: another one pulls the same tendon", true, actuator.place);
      } else if (!tendon.joints.empty() && isServo(actuator) && pushes(actuator)) {
        addLineDrive(tendon, actuator, lineDrive(actuator, path, offset, xml_));
      } else {
        addMuscle(tendon, path, actuator, length, offset);
      }
    }
    if (tendon.range) {
      xml_.add("tendon range", "left out: no limit of a line's length", true, tendon.place);
    }
    if (tendon.friction_loss > 0.0) {
      xml_.add("tendon frictionloss", "left out: a line runs without friction", true, tendon.place);
    }
    if (tendon.stiffness > 0.0 || pulling == 0) {
      addPassive(tendon, pulling == 0 ? tendon.line : tendon.beside, path, offset);
    }
  }

  void addPassive(const MjcfTendon& tendon, const std::string& name, const TendonPath& path, double offset) {
    PassiveTendon passive;
    static_cast<TendonPath&>(passive) = path;
    passive.name = name;
    if (tendon.stiffness == 0.0) {
      passive.kind = tendonKind("constant-force");
      xml_.add("tendon that nothing pulls", "a line under 0 N", false, tendon.place);
      if (tendon.damping > 0.0) {
        xml_.add("tendon damping", "left out of a line without stiffness (motions only)", true, tendon.place);
      }
    } else {
      // Without a springlength it rests where the springs of all joints do (MuJoCo's qpos_spring).
      const double length = lengthAt(path, [](const Joint& joint) { return joint.spring_rest; });
      const std::array<double, 2> rest =
          tendon.spring_length ? std::array{(*tendon.spring_length)[0] - offset, (*tendon.spring_length)[1] - offset}
                               : std::array{length, length};
      const bool only_pulls = rest[0] < rest[1];
      if (only_pulls && tendon.spring_length && (*tendon.spring_length)[0] > 0.0) {
        xml_.add("tendon springlength", "pulls beyond the longer one; that it pushes below the shorter is left out",
                 true, tendon.place);
      }
      passive.kind = tendonKind(only_pulls && rest[1] > 0.0 ? "ligament" : "spring");
      passive.p = {rest[1], tendon.stiffness, tendon.damping};
    }
    places_["tendons " + passive.name] = tendon.place;
    arm_.tendons.push_back(passive);
  }

  void nameAsTendon(const MjcfActuator& actuator, const std::string& name) {
    if (actuator.name.empty() || actuator.name == name) return;
    xml_.add(fmt::format("actuator '{}'", abridged(actuator.name)),
             fmt::format("called '{}' here, as the tendon that it acts on", abridged(name)), false, actuator.place);
  }

  /// Gears and rods between joints push as well as they pull; a line between points is a cord that only pulls.
  void addLineDrive(const MjcfTendon& tendon, const MjcfActuator& actuator, PassiveTendon drive) {
    drive.name = tendon.line;
    nameAsTendon(actuator, drive.name);
    if (tendon.stiffness == 0.0) drive.p[2] += tendon.damping;
    places_["tendons " + drive.name] = tendon.place;
    arm_.tendons.push_back(std::move(drive));
  }

  void addMuscle(const MjcfTendon& tendon, const TendonPath& path, const MjcfActuator& actuator, double length,
                 double offset) {
    Muscle& muscle = addPlaceholderMuscle(arm_, path, tendon.line, length);
    nameAsTendon(actuator, muscle.name);
    const double stiffness = -actuator.gear * actuator.gear * actuator.bias[1];
    if (!actuator.affine || stiffness <= 0.0) {
      xml_.add(wordsOf(actuator), std::string(kPlaceholders), true, actuator.place);
    } else {
      setServo(muscle, actuator, stiffness, offset, xml_);
    }
    // What damps the tendon has no line of its own without a spring: the cord has it, too.
    if (tendon.stiffness == 0.0 && tendon.damping > 0.0) {
      muscle.shock_cord.damping += tendon.damping;
      xml_.add("tendon damping", "a part of the damping of the cord, which damps while it is taut (motions only)", true,
               tendon.place);
    }
    places_["muscles " + muscle.name] = tendon.place;
  }

  /// Actuators of tendons were met with their tendons.
  void addActuator(const MjcfActuator& actuator) {
    if (actuator.tendon.empty()) return addJointDrive(actuator);
    if (std::ranges::find(robot_.tendons, actuator.tendon, &MjcfTendon::name) == robot_.tendons.end()) {
      throw DataError(fmt::format("{}: {}: tendon: found '{}', expected the name of a tendon", actuator.place,
                                  actuator.tag, abridged(actuator.tendon)));
    }
  }

  void addJointDrive(const MjcfActuator& actuator) {
    const auto [joint, reference] = known(actuator.joint, actuator.place);
    if (exertsNothing(actuator)) {
      return xml_.add(wordsOf(actuator), "left out: it exerts no force", false, actuator.place);
    }
    if (const std::string_view why = notDriven(actuator, kindOf(arm_.joints[joint].type)); !why.empty()) {
      return xml_.add(wordsOf(actuator), fmt::format("left out: {}", why), true, actuator.place);
    }
    PassiveTendon drive = jointDrive(actuator, arm_.joints[joint], joint, reference, xml_);
    drive.name = actuator.drive;
    places_["tendons " + drive.name] = actuator.place;
    arm_.tendons.push_back(std::move(drive));
  }

  XmlRobot& xml_;
  const MjcfRobot& robot_;
  ArmModel arm_;
  std::vector<Home> homes_;
  ArmPlaces places_;
  std::map<std::string, Known> joint_of_;  ///< by the file's name, which may be another than the arm's
  std::set<std::string> names_ = {"world"};
};

}  // namespace

ImportedArm readMjcf(const std::string& text, const std::filesystem::path& path, const FileReader& read) {
  MjcfFile file(text, path, read);
  const MjcfRobot robot = readMjcfRobot(file);
  MjcfArm arm(file, robot);
  ArmModel model = arm.build(path);
  std::vector<ExchangeRemark> remarks = file.finish();
  return {checkedArm(std::move(model), path, arm.places()), std::move(remarks)};
}

}  // namespace simgap
