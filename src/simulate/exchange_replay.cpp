#include "simgap/simulate/exchange_replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "simgap/core/decompositions.h"
#include "simgap/core/error.h"
#include "simgap/core/names.h"
#include "simgap/core/random.h"
#include "simgap/model/arm/kinematics.h"
#include "simgap/model/arm/tendon_path.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

constexpr int kPositions = 100;
constexpr int kRests = 20;
constexpr double kWidestBall = 1.0;    ///< [rad]
constexpr double kDrawnSlide = 0.1;    ///< [m]
constexpr double kMostPull = 0.15;     ///< of a muscle's path
constexpr double kNoStiffness = 1e-6;  ///< [N m/rad], [N/m] that only rounding leaves
constexpr double kNoMass = 1.5e-6;   ///< [kg] that MuJoCo wants of a body that moves, and no more: no centre to compare
constexpr double kNoInertia = 1e-9;  ///< [kg m^2] below which MuJoCo may want a little more
constexpr double kNoForce = 1e-9;    ///< [N], [N m] that only rounding leaves
constexpr double kElsewhere = 1e-6;  ///< [m], [rad] beyond what two searches for one rest leave

class Replay {
 public:
  Replay(const ArmModel& original, const ArmModel& read_back, bool links_in_joints)
      : one_(original), other_(read_back), links_(links_in_joints), random_(1) {
    one_.extensions.clear();
    for (const Body& body : one_.bodies) {
      if (!body.fixed) bodies_.push_back(indexOf(other_.bodies, body.name, "body"));
    }
  }

  ExchangeReplay run() {
    ExchangeReplay result;
    compareMasses(result);
    for (int i = 0; i < kPositions; ++i, ++result.positions) {
      const std::vector<JointPosition> joints = randomPosition(i);
      compare(joints, translated(joints), result.way, result.turn);
    }
    // What other formats have no word for is named by a remark; the rest is compared without it.
    for (Joint& joint : one_.joints) {
      const int same = simgap::indexOf(other_.joints, joint.name);
      if (same < 0 || other_.joints[same].stop.stiffness == 0.0) joint.stop = {};
    }
    std::erase_if(one_.tendons, [&](const PassiveTendon& line) {
      return line.kind->command &&
             std::ranges::find(other_.tendons, line.name, &PassiveTendon::name) == other_.tendons.end();
    });
    if (one_.commands() > 0 && one_.muscles.size() == other_.muscles.size() && one_.commands() == other_.commands()) {
      compareRests(result);
    }
    return result;
  }

 private:
  template <typename T>
  static int indexOf(const std::vector<T>& list, const std::string& name, const char* what) {
    const int found = simgap::indexOf(list, name);
    if (found < 0) throw NumericsError(fmt::format("read back, {} '{}' is missing", what, name));
    return found;
  }

  double uniform(int individual, std::size_t parameter, std::uint32_t purpose) const {
    return random_.uniform({0, static_cast<std::uint32_t>(individual), static_cast<std::uint32_t>(parameter), purpose});
  }

  std::vector<JointPosition> randomPosition(int individual) const {
    std::vector<JointPosition> joints(one_.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Joint& joint = one_.joints[j];
      Eigen::Vector3d u;
      for (std::uint32_t k = 0; k < 3; ++k) u[k] = uniform(individual, j, k);
      const double widest = joint.slides() ? kDrawnSlide : std::numbers::pi;
      const double lower = std::max(joint.lower_limit, -widest), upper = std::min(joint.upper_limit, widest);
      joints[j].angle = lower + u[0] * (std::max(lower, upper) - lower);
      joints[j].rotation = expSo3(kWidestBall * (2.0 * u - Eigen::Vector3d::Ones()));
    }
    coupleJoints(one_, joints);
    return joints;
  }

  /// The same position of the other arm.
  std::vector<JointPosition> translated(const std::vector<JointPosition>& joints) const {
    std::vector<JointPosition> theirs(other_.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Joint& joint = one_.joints[j];
      const bool gone =
          !joint.hasAxis() && std::ranges::find(other_.joints, joint.name, &Joint::name) == other_.joints.end();
      if (gone) {                                                         // a ball as three hinges
        const Eigen::Matrix3d r = joints[j].rotation.toRotationMatrix();  // Rx Ry Rz
        const std::array<double, 3> angles = {std::atan2(-r(1, 2), r(2, 2)),
                                              std::atan2(r(0, 2), std::hypot(r(1, 2), r(2, 2))),
                                              std::atan2(-r(0, 1), r(0, 0))};
        const std::array<const char*, 3> letters = {"_x", "_y", "_z"};
        for (std::size_t k = 0; k < 3; ++k) {
          theirs[indexOf(other_.joints, joint.name + letters[k], "joint")].angle = angles[k];
        }
        continue;
      }
      JointPosition& same = theirs[indexOf(other_.joints, joint.name, "joint")];
      same.angle = joints[j].angle;
      // A ball turns in its own frame on the child there, in the child's here.
      const Joint& other = other_.joints[indexOf(other_.joints, joint.name, "joint")];
      const Eigen::Quaterniond between = other.child_orientation.conjugate() * joint.child_orientation;
      same.rotation = between * joints[j].rotation * between.conjugate();
    }
    return theirs;
  }

  void compare(std::span<const JointPosition> joints, std::span<const JointPosition> theirs, double& way,
               double& turn) const {
    const std::vector<BodyInWorld> here = bodiesInWorld(one_, joints), there = bodiesInWorld(other_, theirs);
    std::vector<BodyInWorld> expected = here;
    for (const Joint& joint : one_.joints) {
      if (!links_) break;
      expected[joint.child].origin = here[joint.child] * joint.child_position;
      expected[joint.child].rotation = here[joint.child].rotation * joint.child_orientation.toRotationMatrix();
    }
    for (std::size_t b = 0, k = 0; b < one_.bodies.size(); ++b) {
      if (one_.bodies[b].fixed) continue;
      const BodyInWorld& other = there[bodies_[k++]];
      way = std::max(way, (expected[b].origin - other.origin).norm());
      turn =
          std::max(turn, geodesicAngle(Eigen::Quaterniond(expected[b].rotation), Eigen::Quaterniond(other.rotation)));
    }
  }

  /// Mass, its centre and its inertia about that centre, where both arms begin.
  void compareMasses(ExchangeReplay& result) const {
    const std::vector<JointPosition> joints = startPosition(one_);
    const std::vector<BodyInWorld> here = bodiesInWorld(one_, joints),
                                   there = bodiesInWorld(other_, translated(joints));
    const auto inWorld = [](const MassProperties& body, const BodyInWorld& frame) -> Eigen::Matrix3d {
      return frame.rotation * body.inertia * frame.rotation.transpose();
    };
    for (std::size_t b = 0, k = 0; b < one_.bodies.size(); ++b) {
      if (one_.bodies[b].fixed) continue;
      const int same = bodies_[k++];
      const MassProperties ours = massProperties(one_.bodies[b]), theirs = massProperties(other_.bodies[same]);
      if (std::max(ours.mass, theirs.mass) <= kNoMass) continue;
      const Eigen::Matrix3d inertia = inWorld(ours, here[b]);
      const double size = std::max(inertia.norm(), kNoInertia);
      result.mass = std::max(result.mass, std::abs(ours.mass - theirs.mass));
      result.centre =
          std::max(result.centre, (here[b] * ours.centre_of_mass - there[same] * theirs.centre_of_mass).norm());
      result.inertia = std::max(result.inertia, (inertia - inWorld(theirs, there[same])).norm() / size);
    }
  }

  /// Whether rounding has a say in where an arm rests, as with two fingers that only a coupling holds: a way to go
  /// that nothing resists, or a stop that nothing presses against.
  bool loose(EquilibriumArm& arm) const {
    arm.linearise();
    const int dofs = arm.energy().degreesOfFreedom();
    Eigen::MatrixXd moves = couplingsOf(arm.energy());
    if (moves.size() == 0) moves.setIdentity(dofs, dofs);
    const Eigen::VectorXd force = moves.transpose() * arm.energy().gradient();
    Eigen::MatrixXd stiffness = moves.transpose() * arm.energy().hessian() * moves;
    for (int dof = 0; dof < dofs; ++dof) {
      const bool follows = moves(dof, dof) == 0.0;
      if (!follows && !arm.atStop(dof)) continue;
      if (!follows && std::abs(force[dof]) < kNoForce) return true;
      stiffness.row(dof).setZero();
      stiffness.col(dof).setZero();
      stiffness(dof, dof) = 1.0;
    }
    return symmetricEigen(stiffness).values[0] < kNoStiffness;
  }

  /// Shafts that shorten or lengthen a line by a part of its path.
  void compareRests(ExchangeReplay& result) {
    EquilibriumArm here(one_), there(other_);
    const std::vector<JointPosition> start = startPosition(one_);
    const std::vector<BodyInWorld> bodies = bodiesInWorld(one_, start);
    for (int i = 0; i < kRests; ++i) {
      std::vector<double> shafts;
      for (std::size_t m = 0; m < one_.muscles.size(); ++m) {
        const Muscle& muscle = one_.muscles[m];
        const double length = tendonLength(one_, muscle, bodies, start);
        shafts.push_back((uniform(i, m, 9) - 0.3) * kMostPull * std::abs(length) / muscle.spindle_radius);
      }
      for (const PassiveTendon& line : one_.tendons) {
        if (line.kind->command) shafts.push_back(uniform(i, shafts.size(), 10) * line.kind->command.typical);
      }
      if (!here.solve(shafts).stable) {
        ++result.not_compared;
        continue;
      }
      const bool rests = there.solveFrom(translated(here.joints()), shafts).stable;
      double way = 0.0, turn = 0.0;
      compare(here.joints(), there.joints(), way, turn);
      if ((!rests || way > kElsewhere || turn > kElsewhere) && loose(here)) {
        ++result.not_compared;
        continue;
      }
      if (!rests) {
        ++result.restless;
        continue;
      }
      ++result.rests;
      result.rest_way = std::max(result.rest_way, way);
      result.rest_turn = std::max(result.rest_turn, turn);
    }
  }

  ArmModel one_, other_;
  bool links_;
  CounterRandom random_;
  std::vector<int> bodies_;  ///< of the other arm, for each of ours that is not fixed
};

}  // namespace

ExchangeReplay replayExchange(const ArmModel& original, const ArmModel& read_back, bool links_in_joints) {
  return Replay(original, read_back, links_in_joints).run();
}

}  // namespace simgap
