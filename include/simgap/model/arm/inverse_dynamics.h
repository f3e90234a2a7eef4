/// \file
/// What the joints of a tree of bodies have to exert for a motion, linear in what its bodies weigh:
///
///     tau = Y(q, dq, ddq) pi,   per body pi = (m, m c, I_xx, I_xy, I_xz, I_yy, I_yz, I_zz)
///
/// with the first moment m c [kg m] and the inertia I about the origin of the body's own frame, along its axes [kg m^2]
/// (Atkeson, An & Hollerbach 1986). Motions go outwards by recursive Newton-Euler (Luh, Walker & Paul 1980); a body's
/// force and moment are linear in pi, and each joint on its way to the base takes their part along its own axis.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "simgap/model/arm/arm.h"

namespace simgap {

/// Numbers of a body's pi.
inline constexpr Eigen::Index kBodyParameters = 10;
using BodyParameters = Eigen::Matrix<double, kBodyParameters, 1>;
/// A row per coordinate.
using RegressorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// "m", "mc_x", …, "I_zz".
std::span<const char* const> bodyParameterNames();
BodyParameters parametersOf(const MassProperties& mass);
/// The other way round. \param pi  of a mass > 0
MassProperties massPropertiesOf(const BodyParameters& pi);

/// Coordinates are the joints that follow no other, bodies those that are not fixed, both in the order of the arm.
class InverseDynamics {
 public:
  /// \throws ConfigError: a ball, which has no single coordinate.
  explicit InverseDynamics(const ArmModel& model);

  /// The joint of each coordinate, shape (N).
  const std::vector<int>& joints() const { return coordinates_; }
  /// Each moving body, by its index in the arm, shape (B).
  const std::vector<int>& bodies() const { return bodies_; }
  Eigen::Index parameters() const { return kBodyParameters * std::ssize(bodies_); }
  /// Of the arm, shape (10 B).
  Eigen::VectorXd parametersOf(const ArmModel& model) const;
  /// True when the motion of a body can ask anything of a coordinate's joint.
  bool carries(std::size_t coordinate, std::size_t body) const;

  /// Motion of each body and line of each joint; one per thread.
  struct Workspace {
    struct Motion {
      Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
      Eigen::Vector3d origin = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
      Eigen::Vector3d turn_rate = Eigen::Vector3d::Zero(), acceleration = Eigen::Vector3d::Zero();
    };
    struct Line {
      Eigen::Vector3d point, direction;
    };
    std::vector<Motion> bodies;
    std::vector<Line> joints;
  };
  Workspace workspace() const;

  /// Y, shape (N, 10 B). \param position, velocity, acceleration  shape (N), [rad], [m] and their rates.
  /// \param gravity  [m/s^2]
  void regressor(std::span<const double> position, std::span<const double> velocity,
                 std::span<const double> acceleration, const Eigen::Vector3d& gravity, Workspace& work,
                 Eigen::Ref<RegressorMatrix> y) const;
  /// What springs of the joints ask for at that position, of coordinate `c` [N m] or [N].
  double springTorque(std::size_t c, double position) const;

 private:
  struct Link {
    int parent, child, coordinate;
    bool slides;
    double ratio, offset;                    ///< of the joint's position by its coordinate
    Eigen::Matrix3d constant, sine, cosine;  ///< child in parent: constant + sin(q) sine + cos(q) cosine
    Eigen::Vector3d pivot, axis;             ///< in the parent
    Eigen::Vector3d child_pivot;             ///< in the child
    double stiffness, rest;
  };
  void move(std::span<const double> position, std::span<const double> velocity, std::span<const double> acceleration,
            const Eigen::Vector3d& gravity, Workspace& work) const;

  std::vector<Link> links_;
  std::vector<int> coordinates_, bodies_;
  std::vector<std::vector<int>> ways_;  ///< of a moving body: joints between it and the base
  std::size_t all_bodies_ = 0;
};

}  // namespace simgap
