#include "arm_exchange.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/model/arm/tendon_kind.h"

namespace simgap {
namespace {

constexpr double kRounding = 1e-12;

struct ArmList {
  std::string_view key, one;  ///< "bodies", "body"
};
constexpr std::array<ArmList, 4> kArmLists = {
    {{"bodies", "body"}, {"joints", "joint"}, {"muscles", "tendon"}, {"tendons", "tendon"}}};

std::string nameIn(const ArmModel& model, std::string_view list, std::size_t index) {
  const auto name = [&](const auto& things) { return index < things.size() ? things[index].name : std::string(); };
  if (list == "bodies") return name(model.bodies);
  if (list == "joints") return name(model.joints);
  return list == "muscles" ? name(model.muscles) : name(model.tendons);
}

/// Takes `key[3]` off the front of a path. \returns 3; empty, and nothing taken: another path
std::optional<std::size_t> takeIndex(std::string_view& path, std::string_view key) {
  const std::size_t close = path.find(']');
  if (!path.starts_with(key) || path.size() <= key.size() || path[key.size()] != '[') return std::nullopt;
  if (close == std::string_view::npos) return std::nullopt;
  const std::optional<double> index = parseNumber(path.substr(key.size() + 1, close - key.size() - 1));
  if (!index || *index < 0.0) return std::nullopt;
  path.remove_prefix(close + 1);
  return static_cast<std::size_t>(*index);
}

/// "arm:9: bodies[1].parts[0]: found …" of an arm that no one has seen yet, as the file says it that was given.
std::string inGivenFile(std::string_view error, const ArmModel& model, const std::string& file,
                        const ArmPlaces& places) {
  if (error.starts_with("arm:")) error.remove_prefix(std::min(error.find(": ") + 2, error.size()));
  for (const auto& [key, one] : kArmLists) {
    const std::optional<std::size_t> index = takeIndex(error, key);
    if (!index) continue;
    std::string name = nameIn(model, key, *index);
    // A part has the name of what the file calls a body or a link.
    if (const std::optional<std::size_t> part = takeIndex(error, ".parts")) {
      if (*part < model.bodies[*index].parts.size()) name = model.bodies[*index].parts[*part].name;
    }
    error.remove_prefix(std::min(error.find_first_not_of(".: "), error.size()));
    const auto place = places.find(fmt::format("{} {}", key, name));
    return fmt::format("{}: {} '{}': {}", place == places.end() ? file : place->second, one, abridged(name), error);
  }
  return fmt::format("{}: {}", file, error);
}

}  // namespace

Eigen::Quaterniond tidyRotation(const Eigen::Matrix3d& rotation) {
  if ((rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRounding) {
    return Eigen::Quaterniond::Identity();
  }
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q;
}

Eigen::Vector3d tidyAxis(Eigen::Vector3d axis) {
  for (double& x : axis) {
    if (std::abs(x) < kRounding) x = 0.0;
  }
  return axis.normalized();
}

Eigen::Isometry3d drawnPose(const Joint& joint) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = (joint.parent_orientation * joint.child_orientation.conjugate()).toRotationMatrix();
  frame.translation() = joint.parent_position - frame.linear() * joint.child_position;
  return frame;
}

Part statedPart(const std::string& name, const MassProperties& mass) {
  Part part;
  part.name = name;
  part.shape = Part::Shape::kInertia;
  part.mass = mass.mass;
  part.position = mass.centre_of_mass;
  part.inertia = 0.5 * (mass.inertia + mass.inertia.transpose());
  return part;
}

std::string freePartName(const Body& body, const std::string& wanted) {
  std::string name = wanted;
  const auto taken = [&](const std::string& n) {
    return std::ranges::find(body.parts, n, &Part::name) != body.parts.end();
  };
  for (int i = 2; taken(name); ++i) name = fmt::format("{}_{}", wanted, i);
  return name;
}

void tieJoints(ArmModel& model, int joint, int of, double ratio, double offset, const std::string& place) {
  const bool turned = of > joint;
  Joint& follower = model.joints[std::max(joint, of)];
  if (joint == of || follower.follows() || (turned && ratio == 0.0)) {
    throw DataError(fmt::format("{}: found joints that are tied twice, to themselves, or by 0", place));
  }
  follower.leader = std::min(joint, of);
  follower.coupling_ratio = turned ? 1.0 / ratio : ratio;
  follower.coupling_offset = turned ? -offset / ratio : offset;
}

void checkMasses(const ArmModel& model, const std::filesystem::path& file, const ArmPlaces& places) {
  std::vector<double> carried;
  for (const Body& body : model.bodies) carried.push_back(massProperties(body).mass);
  for (auto joint = model.joints.rbegin(); joint != model.joints.rend(); ++joint) {
    const int child = joint->child;
    if (carried[child] <= 0.0) {
      const std::string& name = model.bodies[child].name;
      const auto place = places.find("bodies " + name);
      throw DataError(fmt::format("{}: body '{}' moves without any mass, expected some (inertial, geoms)",
                                  place == places.end() ? file.filename().string() : place->second, abridged(name)));
    }
    carried[joint->parent] += carried[child];
  }
}

const TendonKind* tendonKind(std::string_view name) {
  for (const TendonKind* kind : tendon_kinds::all()) {
    if (kind->name == name) return kind;
  }
  throw std::logic_error(fmt::format("no kind of tendon is called {}", name));
}

Muscle placeholderMuscle(double length) {
  Muscle muscle;
  muscle.shock_cord = {.rest_length = std::clamp(0.5 * length, 0.005, 0.08), .stiffness = 900.0, .damping = 15.0};
  muscle.kite_line_length = length - muscle.shock_cord.rest_length;
  muscle.spindle_radius = 0.006;
  muscle.motor = {.resistance = 0.8,
                  .inductance = 0.0003,
                  .back_emf_constant = 0.011,
                  .torque_constant = 0.011,
                  .inertia = 2.0e-6,
                  .viscous_friction = 1.0e-6,
                  .coulomb_friction = 0.002,
                  .supply_voltage = 12.0};
  muscle.gearbox = {
      .ratio = 72.0, .efficiency = 0.72, .inertia = 1.0e-5, .viscous_friction = 0.002, .coulomb_friction = 0.03};
  return muscle;
}

Muscle& addPlaceholderMuscle(ArmModel& arm, const TendonPath& path, const std::string& name, double length) {
  Muscle& muscle = arm.muscles.emplace_back(placeholderMuscle(length));
  static_cast<TendonPath&>(muscle) = path;
  muscle.name = name;
  arm.motor_defaults = muscle.motor;
  arm.gearbox_defaults = muscle.gearbox;
  return muscle;
}

ArmModel checkedArm(ArmModel model, const std::filesystem::path& file, const ArmPlaces& places) {
  checkMasses(model, file, places);
  try {
    return readArm(YamlNode::parse(writeArm(model), "arm"));
  } catch (const ConfigError& error) {
    throw DataError(inGivenFile(error.what(), model, file.filename().string(), places));
  }
}

}  // namespace simgap
