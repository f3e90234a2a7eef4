#include "reality/robot_flaws.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>

#include "simgap/core/random.h"

namespace simgap::reality {
namespace {

using Eigen::AngleAxisd;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

class FlawDraws {
 public:
  explicit FlawDraws(std::uint64_t seed) : random_(seed) {}
  double between(double lower, double upper) { return lower + (upper - lower) * random_.uniform({next_++, 0, 7, 9}); }
  double signedBetween(double lower, double upper) {
    const double size = between(lower, upper);
    return between(0.0, 1.0) < 0.5 ? -size : size;
  }
  std::size_t below(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(between(0.0, static_cast<double>(count))));
  }
  Vector3d inBall(double radius) {
    return {between(-radius, radius), between(-radius, radius), between(-radius, radius)};
  }

 private:
  CounterRandom random_;
  std::uint32_t next_ = 0;
};

/// One flaw of a size; 1 is where scaling begins.
struct FlawKind {
  /// Puts it into the link, of `size`; says the target.
  std::function<std::string(Robot&, std::size_t, double, FlawDraws&)> put;
  bool scaled;  ///< its size is found from what it changes
};

std::string jointName(std::size_t k) { return fmt::format("j{}", k + 1); }
std::string linkName(std::size_t k) { return fmt::format("link{}", k + 1); }

const std::map<std::string, FlawKind>& flawKinds() {
  static const std::map<std::string, FlawKind> all = {
      {"payload",
       {[](Robot& r, std::size_t k, double size, FlawDraws& d) {
          const Vector3d at = d.inBall(0.25);
          hang(r.links[k], 0.1 * size * d.between(0.5, 1.5), at);
          return linkName(k);
        },
        true}},
      {"link-inertia",
       {[](Robot& r, std::size_t k, double size, FlawDraws& d) {
          const double z = d.between(0.05, 0.3), y = d.between(0.05, 0.3), x = d.between(0.05, 0.3);
          const Vector3d edges(x, y, z), axis = d.inBall(1.0).normalized();
          const Matrix3d turn = AngleAxisd(d.between(-3.0, 3.0), axis).toRotationMatrix();
          const Vector3d s = edges.cwiseAbs2();
          const Vector3d moments(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
          r.links[k].inertia += size * turn * Matrix3d(moments.asDiagonal()) * turn.transpose();
          return linkName(k);
        },
        true}},
      {"rotor-inertia",
       {[](Robot& r, std::size_t k, double size, FlawDraws&) {
          r.links[k].rotor += 0.1 * size;
          return jointName(k);
        },
        true}},
      {"coulomb-offset",
       {[](Robot& r, std::size_t k, double size, FlawDraws&) {
          r.links[k].coulomb += 0.1 * size;
          return jointName(k);
        },
        true}},
      {"viscous-friction",
       {[](Robot& r, std::size_t k, double size, FlawDraws&) {
          r.links[k].viscous += 0.1 * size;
          return jointName(k);
        },
        true}},
      {"current-bias",
       {[](Robot& r, std::size_t k, double size, FlawDraws& d) {
          r.links[k].bias = d.between(0.0, 1.0) < 0.5 ? -0.1 * size : 0.1 * size;
          return jointName(k);
        },
        true}},
      {"viscous-asymmetry",
       {[](Robot& r, std::size_t k, double size, FlawDraws&) {
          r.links[k].viscous_forwards = 0.1 * size;
          return jointName(k);
        },
        true}},
      {"viscous-nonlinearity",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          RobotLink& link = r.links[k];
          link.viscous_power = d.between(0.0, 1.0) < 0.5 ? d.between(0.3, 0.5) : d.between(1.8, 2.5);
          link.top_speed = link.slides ? 0.3 : 1.5;
          return jointName(k);
        },
        false}},
      {"load-dependence",
       {[](Robot& r, std::size_t k, double size, FlawDraws&) {
          r.links[k].load_friction = 0.02 * size;
          return jointName(k);
        },
        true}},
      {"coupled-friction",
       {[](Robot& r, std::size_t k, double size, FlawDraws& d) {
          const bool up = r.links[k].parent < 0;
          std::size_t other = up ? k : static_cast<std::size_t>(r.links[k].parent);
          for (std::size_t c = 0; c < r.links.size(); ++c) {
            if (r.links[c].parent == static_cast<int>(k) && (up || d.between(0.0, 1.0) < 0.5)) other = c;
          }
          r.links[k].coupled_to = static_cast<int>(other);
          r.links[k].coupled_friction = 0.02 * size;
          return jointName(k) + " by " + jointName(other);
        },
        true}},
      {"position-ripple",
       {[](Robot& r, std::size_t k, double size, FlawDraws& d) {
          RobotLink& link = r.links[k];
          link.ripple = 0.1 * size;
          link.ripple_ratio = std::round(d.between(6.0, 30.0)) * (link.slides ? 5.0 : 1.0);
          link.ripple_phase = d.between(0.0, 6.0);
          return jointName(k);
        },
        true}},
      {"channel-delay",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          r.links[k].effort_late = d.between(0.02, 0.06);
          return jointName(k);
        },
        false}},
      {"clock-offset",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          r.links[k].clock_late = d.signedBetween(0.03, 0.1);
          return jointName(k);
        },
        false}},
      {"position-delay",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          r.links[k].position_late = d.between(0.02, 0.06);
          return jointName(k);
        },
        false}},
      {"joint-offset",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          r.links[k].zero = d.signedBetween(0.05, 0.15) * (r.links[k].slides ? 0.2 : 1.0);
          return jointName(k);
        },
        false}},
      {"torque-constant",
       {[](Robot& r, std::size_t k, double, FlawDraws& d) {
          r.links[k].effort_gain = 1.0 + d.signedBetween(0.06, 0.2);
          return jointName(k);
        },
        false}},
      {"gravity-tilt",
       {[](Robot& r, std::size_t, double, FlawDraws& d) {
          const double y = d.between(-1.0, 1.0), x = d.between(-1.0, 1.0);
          const Vector3d axis = Vector3d(x, y, 0.0).normalized();
          r.gravity = AngleAxisd(d.between(0.04, 0.12), axis) * r.gravity;
          return std::string();
        },
        false}},
  };
  return all;
}

/// Came when the study's figures stood: a seed there hides what it always hid.
constexpr std::string_view kLater = "position-delay";

}  // namespace

const std::vector<std::string>& robotFlawNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& [name, kind] : flawKinds()) {
      if (name != kLater) list.push_back(name);
    }
    return list;
  }();
  return names;
}

RobotFlaw hideFlaw(const Robot& robot, const std::string& cause, const RobotRigOptions& options, std::uint64_t motion,
                   std::uint64_t draw) {
  const FlawKind& kind = flawKinds().at(cause);
  FlawDraws draws(draw);
  const std::size_t link = draws.below(robot.links.size());
  const double wanted = draws.between(0.7, 4.0);
  RobotFlaw flaw{cause, {}, robot};
  FlawDraws first = draws;
  flaw.target = kind.put(flaw.robot, link, 1.0, first);
  if (!kind.scaled) return flaw;
  const MatrixXd before = loggedTorques(robot, options, motion), after = loggedTorques(flaw.robot, options, motion);
  double largest = 0.0;
  for (Index j = 0; j < before.cols(); ++j) {
    const double noise = options.torque_noise * before.col(j).norm();
    if (noise > 0.0) largest = std::max(largest, (after.col(j) - before.col(j)).norm() / noise);
  }
  flaw.robot = robot;
  kind.put(flaw.robot, link, wanted / std::max(largest, 1e-6), draws);
  return flaw;
}

}  // namespace simgap::reality
